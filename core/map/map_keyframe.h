// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include "core/geometry/se3.h"

namespace plslam {

/// A keyframe as the map knows it. Its features stay with whoever needs them.
struct MapKeyframe {
  /// 0, 1, 2, ... in the order of insertion, over all sessions; never used again.
  int64_t id = -1;
  /// Where it comes from: the odometry session, and its number and frame there.
  int64_t session = 0;
  int64_t session_keyframe_id = -1;
  int64_t frame_id = -1;
  int64_t t_ns = 0;
  /// Covariance of the right perturbation, relative to the first keyframe of the map.
  SE3 T_w_kf;
  Matrix6d covariance = Matrix6d::Zero();
  /// Where odometry saw it.
  SE3 T_odom_kf;
  /// The keyframe before it in its session (-1: none) and the motion between as first measured, with the covariance
  /// of its right perturbation.
  int64_t previous_id = -1;
  SE3 T_prevkf_kf;
  Matrix6d relative_covariance = Matrix6d::Zero();
  /// Parent in the spanning tree: the keyframe that it shared most landmarks with when it came (`Map::kParent` at
  /// least), else the one before it; -1 for the first, and where it shares too little with any.
  int64_t parent_id = -1;
};

}  // namespace plslam
