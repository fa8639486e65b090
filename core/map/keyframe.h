// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "core/features/features.h"
#include "core/geometry/se3.h"
#include "core/geometry/stereo_camera.h"

namespace plslam {

/// A landmark that a keyframe has shown and that turned out to be of a moving body: its number in vo_process and,
/// where known, in the map; -1 where there is none.
struct Withdrawn {
  int64_t landmark_id = -1;
  int64_t map_id = -1;

  template <class Archive, class Self>
  static void Fields(Archive& a, Self& self) {
    a(self.landmark_id, self.map_id);
  }
};

/// What vo_process hands on of a keyframe; the content of `keyframe_t`.
struct Keyframe {
  int64_t source = 0;   ///< publisher; set by the receiver
  int64_t session = 0;  ///< odometry session
  int64_t t_ns = 0;
  /// 0, 1, 2, ... in each session.
  int64_t keyframe_id = 0;
  int64_t frame_id = 0;
  /// -1 for the first of a session; then `T_prevkf_kf` is identity and `covariance` zero.
  int64_t previous_keyframe_id = -1;
  /// `MapUpdate::began_version` of the map that the session began with: it is meant for no other one.
  int64_t map_began_version = 0;
  SE3 T_prevkf_kf;
  /// Of T_prevkf_kf, right perturbation in kf.
  Matrix6d covariance = Matrix6d::Zero();
  SE3 T_odom_kf;
  /// Tracking state, as in `pose_t.state`.
  int state = 0;
  /// The stream waits for the map: every keyframe is adjusted to the end before the next (same result at every run).
  bool lockstep = false;
  /// The rectified camera that the features are told in.
  StereoCamera camera;
  StereoFeatures features;
  /// Landmark of vo_process that each feature was tracked from or created, or -1. As long as the features.
  std::vector<int64_t> point_landmark_ids;
  std::vector<int64_t> line_landmark_ids;
  /// Landmark of the map that each feature was tracked as, or -1. As long as the features, or empty: none.
  std::vector<int64_t> point_map_ids;
  std::vector<int64_t> line_map_ids;
  std::vector<Withdrawn> withdrawn_points;
  std::vector<Withdrawn> withdrawn_lines;

  /// Takes over features of which none is known to show a landmark.
  void SetFeatures(StereoFeatures seen) {
    point_landmark_ids.assign(seen.points.size(), -1);
    line_landmark_ids.assign(seen.lines.size(), -1);
    features = std::move(seen);
  }
};

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
