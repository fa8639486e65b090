#pragma once

#include <optional>

#include "core/motion/motion_estimator.h"
#include "core/motion/residual.h"

namespace plslam {

/// A point ready for many linearisations: checked, and weighted as the options say.
struct PreparedPoint {
  Eigen::Vector3d p_ref;
  Eigen::Matrix3d covariance;
  Eigen::Vector3d uvd;
  double sigma_px;
  double sigma_disparity_px;
  bool has_disparity;
};

/// nullopt for what cannot be used: anything not finite, sigmas that are not positive, a position that is unknown.
std::optional<PreparedPoint> Prepare(const PointObservation& observation, const MotionOptions& options);

/// Residual measured minus predicted (u, v, disparity), in pixels, with sigmas of at least `sigma_floor_px`. False when
/// the point is behind the camera or too near.
bool Linearize(const PreparedPoint& point, const PoseView& view, double sigma_floor_px, Residual<3>& residual);

}  // namespace plslam
