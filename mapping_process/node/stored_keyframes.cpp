// SPDX-License-Identifier: BSD-3-Clause
#include "mapping_process/node/stored_keyframes.h"

namespace plslam {
namespace {

Keyframe KeyframeOf(const MapKeyframe& entry, const StereoFeatures& features, const Map& map) {
  Keyframe keyframe;
  keyframe.session = entry.session;
  keyframe.t_ns = entry.t_ns;
  keyframe.keyframe_id = entry.session_keyframe_id;
  keyframe.frame_id = entry.frame_id;
  const MapKeyframe* previous = map.FindKeyframe(entry.previous_id);
  if (previous != nullptr) keyframe.previous_keyframe_id = previous->session_keyframe_id;
  keyframe.T_prevkf_kf = entry.T_prevkf_kf;
  keyframe.covariance = entry.relative_covariance;
  keyframe.T_odom_kf = entry.T_odom_kf;
  keyframe.state = 1;
  keyframe.features = features;
  keyframe.point_landmark_ids.assign(features.points.size(), -1);
  keyframe.line_landmark_ids.assign(features.lines.size(), -1);
  return keyframe;
}

}  // namespace

std::vector<Keyframe> KeyframesOf(const StoredMap& stored) {
  std::vector<Keyframe> keyframes;
  for (const auto& [id, entry] : stored.map.keyframes()) {
    const auto features = stored.features.find(id);
    if (features != stored.features.end()) keyframes.push_back(KeyframeOf(entry, features->second, stored.map));
  }
  return keyframes;
}

}  // namespace plslam
