// SPDX-License-Identifier: BSD-3-Clause
#include "vo_process/node/vo_messages.h"

#include <algorithm>
#include <vector>

#include "core/bus/messages/convert.h"

namespace plslam::vo {
namespace {

void CopyPixel(const Eigen::Vector2d& px, float (&to)[2]) {
  to[0] = static_cast<float>(px.x());
  to[1] = static_cast<float>(px.y());
}

}  // namespace

pose_t ToPoseMessage(const OdometryResult& result, const SE3& T_w_odom, bool anchored,
                     const std::vector<StageTime>& stages) {
  pose_t message;
  message.state = static_cast<int8_t>(result.state);
  message.T_odom_c = bus::ToMessage(result.T_odom_c);
  message.T_w_odom = bus::ToMessage(T_w_odom);
  message.anchored = anchored ? 1 : 0;
  bus::ToArray(result.covariance, message.covariance);
  message.T_prev_c = bus::ToMessage(result.T_prev_c);
  bus::ToArray(result.motion_covariance, message.motion_covariance);
  bus::ToArray(result.up, message.up_c, message.up_sigma_rad);
  message.keyframe_id = result.keyframe ? result.keyframe->id : -1;
  message.entropy_ratio = result.entropy_ratio;
  message.n_points = static_cast<int32_t>(result.features.points.size());
  message.n_lines = static_cast<int32_t>(result.features.lines.size());
  message.n_tracked_points = result.n_tracked_points;
  message.n_tracked_lines = result.n_tracked_lines;
  message.n_moving = result.n_moving;
  message.n_bodies = result.n_bodies;
  message.n_skipped_frames = 0;
  for (const StageTime& stage : stages) {
    stage_t& time = message.stages.emplace_back();
    time.name = stage.name;
    time.ms = stage.ms;
  }
  message.n_stages = static_cast<int32_t>(message.stages.size());
  return message;
}

namespace {

/// Removes tracks from the end, or only new ones among them, until `excess_bytes` are saved; returns the remaining
/// excess.
template <class Track>
int64_t LeaveOut(int64_t excess_bytes, bool only_new, std::vector<Track>& tracks) {
  constexpr int kLeftOut = -1;
  for (auto track = tracks.rbegin(); track != tracks.rend() && excess_bytes > 0; ++track) {
    if (only_new && track->age > 0) continue;
    excess_bytes -= track->_getEncodedSizeNoHash();
    track->age = kLeftOut;
  }
  std::erase_if(tracks, [](const Track& track) { return track.age == kLeftOut; });
  return excess_bytes;
}

}  // namespace

tracks_t ToTracksMessage(const OdometryResult& result, int64_t max_bytes) {
  tracks_t message;
  for (size_t i = 0; i < result.features.points.size(); ++i) {
    const StereoPoint& point = result.features.points[i];
    track_point_t& track = message.points.emplace_back();
    track.u_px = static_cast<float>(point.left.px.x());
    track.v_px = static_cast<float>(point.left.px.y());
    track.disparity_px = static_cast<float>(point.disparity_px);
    track.age = result.point_tracks[i].age;
    track.body = static_cast<int8_t>(result.point_tracks[i].body);
  }
  for (size_t i = 0; i < result.features.lines.size(); ++i) {
    const StereoLine& line = result.features.lines[i];
    track_line_t& track = message.lines.emplace_back();
    CopyPixel(line.left.segment.p, track.p_px);
    CopyPixel(line.left.segment.q, track.q_px);
    track.disparity_p_px = line.HasDepth() ? static_cast<float>(line.disparity_p_px) : -1.0F;
    track.disparity_q_px = line.HasDepth() ? static_cast<float>(line.disparity_q_px) : -1.0F;
    track.age = result.line_tracks[i].age;
    track.body = static_cast<int8_t>(result.line_tracks[i].body);
  }
  message.n_points = static_cast<int32_t>(message.points.size());
  message.n_lines = static_cast<int32_t>(message.lines.size());
  int64_t excess_bytes = message.getEncodedSize() - max_bytes;
  for (const bool only_new : {true, false}) {
    excess_bytes = LeaveOut(excess_bytes, only_new, message.points);
    excess_bytes = LeaveOut(excess_bytes, only_new, message.lines);
  }
  message.n_points = static_cast<int32_t>(message.points.size());
  message.n_lines = static_cast<int32_t>(message.lines.size());
  return message;
}

namespace {

std::vector<LandmarkId> MapIds(const std::vector<FeatureTrack>& tracks) {
  std::vector<LandmarkId> ids;
  ids.reserve(tracks.size());
  for (const FeatureTrack& track : tracks) ids.push_back(track.map_id);
  return ids;
}

}  // namespace

bodies_t ToBodiesMessage(const std::vector<BodyPose>& bodies) {
  bodies_t message{};
  for (const BodyPose& body : bodies) {
    message.bodies.push_back({body.id, bus::ToMessage(body.T_c_body), body.n_features});
  }
  message.n_bodies = static_cast<int32_t>(message.bodies.size());
  return message;
}

Keyframe ToKeyframe(const OdometryResult& result, const StereoCamera& camera) {
  Keyframe keyframe;
  keyframe.camera = camera;
  keyframe.name.number = result.keyframe->id;
  keyframe.previous_keyframe_id = result.keyframe->previous_id;
  keyframe.T_prevkf_kf = result.keyframe->T_prevkf_kf;
  keyframe.covariance = result.keyframe->covariance;
  keyframe.T_odom_kf = result.T_odom_c;
  keyframe.up = result.up;
  keyframe.inertial = result.keyframe->inertial;
  keyframe.state = static_cast<int>(result.state);
  const KeyframeContent& content = result.keyframe->content;
  keyframe.features = content.features;
  keyframe.point_landmark_ids = TrackedLandmarkIds(content.point_tracks);
  keyframe.line_landmark_ids = TrackedLandmarkIds(content.line_tracks);
  keyframe.point_map_ids = MapIds(content.point_tracks);
  keyframe.line_map_ids = MapIds(content.line_tracks);
  keyframe.withdrawn_points = result.keyframe->withdrawn_points;
  keyframe.withdrawn_lines = result.keyframe->withdrawn_lines;
  return keyframe;
}

int64_t TrackedOfMap(const OdometryResult& result) {
  const auto is_of_map = [](const FeatureTrack& track) { return track.map_id >= 0; };
  return std::count_if(result.point_tracks.begin(), result.point_tracks.end(), is_of_map) +
         2 * std::count_if(result.line_tracks.begin(), result.line_tracks.end(), is_of_map);
}

}  // namespace plslam::vo
