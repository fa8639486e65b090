#pragma once

#include <optional>

#include "core/geometry/stereo_camera.h"
#include "mapping_process/association.h"

namespace plslam {

/// Where a keyframe is, with the covariance of the right perturbation given the landmarks.
struct KeyframePose {
  SE3 T_w_kf;
  Matrix6d covariance = Matrix6d::Zero();
};

/// Pose of a keyframe among the landmarks that its features show (PL-SLAM §IV.C), from `T_w_kf` on. Features that
/// disagree lose their landmark. nullopt, and nothing done, where the pose is not determined.
std::optional<KeyframePose> RefinePose(const Map& map, const StereoFeatures& features, const StereoCamera& camera,
                                       const SE3& T_w_kf, const MotionOptions& options, Association& association);

}  // namespace plslam
