// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include "core/geometry/stereo_camera.h"
#include "core/localisation/local_map.h"
#include "core/motion/motion_estimator.h"

namespace plslam {

/// Returns the correspondence for the motion estimator between a landmark, in a reference frame and with its covariance
/// there, and its observation `seen`.
PointCorrespondence ObservationOf(const Eigen::Vector3d& p_ref, const Eigen::Matrix3d& covariance,
                                  const StereoPoint& seen);
LineCorrespondence ObservationOf(const Segment3& segment_ref, const Eigen::Matrix3d& covariance_p,
                                 const Eigen::Matrix3d& covariance_q, const StereoLine& seen);

/// Pose of a keyframe, with the covariance of its right perturbation given the landmarks.
struct KeyframePose {
  SE3 T_w_kf;
  Matrix6d covariance = Matrix6d::Zero();
};

/// Refines the pose of a keyframe from its associated landmarks (PL-SLAM §IV.C), starting at `T_w_kf`. Outliers are
/// removed from the association. Returns nullopt and does nothing if the pose is not determined.
std::optional<KeyframePose> RefinePose(const Map& map, const FeaturesView& features, const StereoCamera& camera,
                                       const SE3& T_w_kf, const MotionOptions& options, Association& association);

/// As `RefinePose` without a start pose: estimates it from minimal sets, then refines it. Returns nullopt and does
/// nothing if fewer than `min_weight` (points + 2 x lines) agree.
std::optional<KeyframePose> FindPose(const Map& map, const FeaturesView& features, const StereoCamera& camera,
                                     const MotionOptions& options, int min_weight, Association& association);

/// Estimates the pose of a keyframe without a prior: matches its features with the landmarks of `local` by descriptor
/// alone, estimates the pose from minimal sets, and refines it. Returns nullopt if fewer than `min_weight`
/// (points + 2 x lines) agree; otherwise `association` receives the inliers.
std::optional<KeyframePose> RecognisePose(const Map& map, const LocalMap& local, const FeaturesView& features,
                                          const StereoCamera& camera, const LocalisationOptions& options,
                                          int min_weight, Association& association);

}  // namespace plslam
