// SPDX-License-Identifier: BSD-3-Clause
#include "viewer_headless/film_path.h"

#include <iterator>

namespace plslam {

void FilmPath::Add(const FramePose& pose) {
  FrameRecord frame;
  frame.state = pose.state;
  frame.keyframe_id = pose.keyframe_id;
  if (HasPose(frame)) {
    const Eigen::Vector3d& p_odom = pose.T_odom_c.translation();
    steps_.push_back({pose.frame_id, pose.session, p_odom, pose.T_w_odom * p_odom});
  } else if (pose.state == TrackingState::kLost) {
    lost_frames_.insert(pose.frame_id);
  }
}

std::vector<Eigen::Vector3d> FilmPath::In(const Map& map) const {
  const std::map<int64_t, FrameCorrections> sessions = CorrectionsBySession(map);
  std::vector<Eigen::Vector3d> path;
  path.reserve(steps_.size());
  for (const Step& step : steps_) {
    const auto session = sessions.find(step.session);
    const SE3* T_w_odom = session == sessions.end() ? nullptr : CorrectionOf(step, session->second);
    path.push_back(T_w_odom == nullptr ? step.p_w : *T_w_odom * step.p_odom);
  }
  return path;
}

const SE3* FilmPath::CorrectionOf(const Step& step, const FrameCorrections& corrections) const {
  const auto after = corrections.upper_bound(step.frame_id);
  if (after != corrections.begin()) {
    const auto before = std::prev(after);
    if (!IsLostBetween(before->first, step.frame_id)) return &before->second;
  }
  const bool reached = after != corrections.end() && !IsLostBetween(step.frame_id, after->first);
  return reached ? &after->second : nullptr;
}

bool FilmPath::IsLostBetween(int64_t from, int64_t to) const {
  const auto lost = lost_frames_.lower_bound(from);
  return lost != lost_frames_.end() && *lost < to;
}

}  // namespace plslam
