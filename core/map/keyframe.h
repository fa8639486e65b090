// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "core/features/features.h"
#include "core/geometry/se3.h"
#include "core/geometry/stereo_camera.h"
#include "core/geometry/up_direction.h"
#include "core/ids/ids.h"
#include "core/ids/map_version.h"
#include "core/inertial/inertial_interval.h"

namespace plslam {

/// A landmark of earlier keyframes that turned out to be on a moving body: its id in vo_process and, if known, in the
/// map; -1 if it has none.
struct Withdrawn {
  TrackId landmark_id;
  LandmarkId map_id;

  template <class Archive, class Self>
  static void Fields(Archive& a, Self& self) {
    a(self.landmark_id, self.map_id);
  }
};

/// A keyframe as vo_process publishes it; the content of `keyframe_t`.
struct Keyframe {
  SourceId source;  ///< publisher; set by the receiver
  KeyframeName name{.session = {}, .number = 0};
  int64_t t_ns = 0;
  FrameId frame_id = 0;
  /// -1 for the first keyframe of a session; then `T_prevkf_kf` is identity and `covariance` zero.
  int64_t previous_keyframe_id = -1;
  /// The map that the session is part of.
  MapId map_id;
  SE3 T_prevkf_kf;
  /// Covariance of T_prevkf_kf, right perturbation in kf.
  Matrix6d covariance = Matrix6d::Zero();
  SE3 T_odom_kf;
  /// The vertical from the keyframe, if the session has an inertial sensor that knows it.
  std::optional<UpDirection> up;
  /// Since the previous keyframe; empty without an inertial sensor that is used.
  InertialInterval inertial;
  /// Tracking state, as in `pose_t.state`.
  int state = 0;
  /// Whether the stream waits for the map: each keyframe is adjusted to the end before the next (repeatable results).
  bool lockstep = false;
  /// The rectified camera in which the features are expressed.
  StereoCamera camera;
  StereoFeatures features;
  /// Landmark of vo_process that each feature was tracked from or created, or -1. Same length as `features`.
  std::vector<TrackId> point_landmark_ids;
  std::vector<TrackId> line_landmark_ids;
  /// Landmark of the map as which each feature was tracked, or -1. Same length as `features`, or empty if there are
  /// none.
  std::vector<LandmarkId> point_map_ids;
  std::vector<LandmarkId> line_map_ids;
  std::vector<Withdrawn> withdrawn_points;
  std::vector<Withdrawn> withdrawn_lines;

  /// Sets features without associated landmarks.
  void SetFeatures(StereoFeatures seen) {
    point_landmark_ids.assign(seen.points.size(), -1);
    line_landmark_ids.assign(seen.lines.size(), -1);
    features = std::move(seen);
  }
};

/// A keyframe of the map. Its features are stored elsewhere (`KeyframeFeatures`).
struct MapKeyframe {
  /// 0, 1, 2, ... in the order of insertion, over all sessions; never assigned again.
  KeyframeId id = -1;
  KeyframeName name;
  /// Its frame in that session.
  FrameId frame_id = -1;
  int64_t t_ns = 0;
  /// Pose, and covariance of its right perturbation relative to the first keyframe of the map.
  SE3 T_w_kf;
  Matrix6d covariance = Matrix6d::Zero();
  /// Pose by odometry alone.
  SE3 T_odom_kf;
  /// The vertical as measured at the time, from the keyframe.
  std::optional<UpDirection> up;
  /// The previous keyframe of its session (-1: none) and the motion from it as first measured, with the covariance of
  /// its right perturbation.
  KeyframeId previous_id = -1;
  SE3 T_prevkf_kf;
  Matrix6d relative_covariance = Matrix6d::Zero();
  /// Parent in the spanning tree: the keyframe with most shared landmarks at insertion (at least `Map::kParent`), or
  /// else the previous one; -1 for the first, and for one that shares too little with any.
  KeyframeId parent_id = -1;
};

}  // namespace plslam
