// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "core/geometry/se3.h"
#include "core/geometry/up_direction.h"
#include "core/inertial/inertial_interval.h"
#include "core/run/tracking_state.h"
#include "vo_process/tracking/bodies/moving_bodies.h"
#include "vo_process/tracking/landmarks/keyframe_measurements.h"
#include "vo_process/tracking/motion/keyframe_policy.h"

namespace plslam::vo {

/// A frame that became a keyframe: motion since the previous keyframe.
struct KeyframeStep {
  int64_t id = 0;
  KeyframeReason reason = KeyframeReason::kNone;
  /// -1 for the first; then the relative pose is identity with zero covariance.
  int64_t previous_id = -1;
  SE3 T_prevkf_kf;
  Matrix6d covariance = Matrix6d::Zero();
  /// As `Keyframe::inertial`.
  InertialInterval inertial;
  /// Measurements of the frames since the last keyframe, expressed in this one, and their landmarks.
  KeyframeContent content;
  /// Landmarks of earlier keyframes that turned out to be on a moving body.
  std::vector<Withdrawn> withdrawn_points;
  std::vector<Withdrawn> withdrawn_lines;
};

/// Result of odometry for a frame.
struct OdometryResult {
  TrackingState state = TrackingState::kInitialising;
  /// Continuous over the session, identity at its first frame with features; the covariance of its right perturbation
  /// is composed of those of the motions.
  SE3 T_odom_c;
  Matrix6d covariance = Matrix6d::Zero();
  /// Motion since the previous frame; if the pose `jumped`, from the predicted pose of a lost camera to the recovered
  /// one.
  SE3 T_prev_c;
  bool jumped = false;
  /// Whether the frame was found where a relocalisation said.
  bool relocalised = false;
  /// Whether the pose is the inertial sensor's alone, because the frame showed no known landmarks.
  bool carried = false;
  /// Whether features were only followed, not detected.
  bool is_followed = false;
  /// Includes errors that frames have in common (`MotionUncertainty`).
  Matrix6d motion_covariance = Matrix6d::Zero();
  /// The vertical by the inertial sensor, if it is used.
  std::optional<UpDirection> up;
  double entropy_ratio = 0.0;
  std::optional<KeyframeStep> keyframe;
  int n_tracked_points = 0;
  int n_tracked_lines = 0;
  /// Features on moving bodies, and bodies published so far.
  int n_moving = 0;
  int n_bodies = 0;
  std::vector<BodyPose> bodies;
  /// The frame's features and their landmarks.
  StereoFeatures features;
  std::vector<FeatureTrack> point_tracks;
  std::vector<FeatureTrack> line_tracks;
};

}  // namespace plslam::vo
