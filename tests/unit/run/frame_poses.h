// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "core/run/recorder.h"

namespace plslam {

/// Frame `id` at 10 Hz, `id` metres ahead.
inline FramePose SomePose(int64_t id, TrackingState state = TrackingState::kTracking) {
  FramePose pose;
  pose.frame_id = FrameId(id);
  pose.t_ns = 1'000'000'000 + id * 100'000'000;
  pose.session = 7;
  pose.state = state;
  pose.T_odom_c = SE3(Eigen::Quaterniond::Identity(), Eigen::Vector3d(0, 0, static_cast<double>(id)));
  pose.covariance = 1e-4 * static_cast<double>(id) * Matrix6d::Identity();
  pose.motion_covariance = 1e-4 * Matrix6d::Identity();
  pose.counts = {800, 120, 312, 84, 0};
  pose.stages_ms = {{"orb", 4.5}, {"pose", 0.25}};
  return pose;
}

}  // namespace plslam
