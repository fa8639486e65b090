// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include "core/geometry/stereo_camera.h"
#include "core/localisation/local_map.h"
#include "core/motion/motion_estimator.h"

namespace plslam {

/// What the motion estimator needs of a landmark that is `seen`: its place in a reference frame, with covariance
/// there.
PointCorrespondence ObservationOf(const Eigen::Vector3d& p_ref, const Eigen::Matrix3d& covariance,
                                  const StereoPoint& seen);
LineCorrespondence ObservationOf(const Segment3& segment_ref, const Eigen::Matrix3d& covariance_p,
                                 const Eigen::Matrix3d& covariance_q, const StereoLine& seen);

/// Where a keyframe is, with the covariance of the right perturbation given the landmarks.
struct KeyframePose {
  SE3 T_w_kf;
  Matrix6d covariance = Matrix6d::Zero();
};

/// Pose of a keyframe among the landmarks that its features show (PL-SLAM §IV.C), from `T_w_kf` on. Features that
/// disagree lose their landmark. nullopt, and nothing done, where the pose is not determined.
std::optional<KeyframePose> RefinePose(const Map& map, const FeaturesView& features, const StereoCamera& camera,
                                       const SE3& T_w_kf, const MotionOptions& options, Association& association);

/// The same where nothing is known of the pose: from minimal sets, then refined. nullopt, and nothing done, where
/// fewer than `min_weight` (points + 2 x lines) agree.
std::optional<KeyframePose> FindPose(const Map& map, const FeaturesView& features, const StereoCamera& camera,
                                     const MotionOptions& options, int min_weight, Association& association);

/// Where a keyframe is of which nothing is known: its features matched by descriptors alone with the landmarks of
/// `local`, the pose from minimal sets, then refined. nullopt where fewer than `min_weight` (points + 2 x lines)
/// agree; else the association is what agrees.
std::optional<KeyframePose> RecognisePose(const Map& map, const LocalMap& local, const FeaturesView& features,
                                          const StereoCamera& camera, const LocalisationOptions& options,
                                          int min_weight, Association& association);

}  // namespace plslam
