#include "vo_process/node/keyframe_value.h"

namespace plslam {
namespace {

std::vector<int64_t> MapIds(const std::vector<FeatureTrack>& tracks) {
  std::vector<int64_t> ids;
  ids.reserve(tracks.size());
  for (const FeatureTrack& track : tracks) ids.push_back(track.map_id);
  return ids;
}

}  // namespace

Keyframe ToKeyframe(const OdometryResult& result) {
  Keyframe keyframe;
  keyframe.keyframe_id = result.keyframe->id;
  keyframe.previous_keyframe_id = result.keyframe->previous_id;
  keyframe.T_prevkf_kf = result.keyframe->T_prevkf_kf;
  keyframe.covariance = result.keyframe->covariance;
  keyframe.T_odom_kf = result.T_odom_c;
  keyframe.state = static_cast<int>(result.state);
  const KeyframeContent& content = result.keyframe->content;
  keyframe.features = content.features;
  keyframe.point_landmark_ids = TrackedLandmarkIds(content.point_tracks);
  keyframe.line_landmark_ids = TrackedLandmarkIds(content.line_tracks);
  keyframe.point_map_ids = MapIds(content.point_tracks);
  keyframe.line_map_ids = MapIds(content.line_tracks);
  return keyframe;
}

}  // namespace plslam
