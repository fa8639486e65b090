// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include "core/motion/motion_estimator.h"

namespace plslam {

/// A validated point, weighted according to the options, for `PointBatch`.
struct PreparedPoint {
  Eigen::Vector3d p_ref;
  Eigen::Matrix3d covariance;
  Eigen::Vector3d uvd;
  double sigma_px;
  double sigma_disparity_px;
  bool has_disparity;
};

/// Returns nullopt for an invalid correspondence: values that are not finite, sigmas that are not positive, an
/// undetermined position.
std::optional<PreparedPoint> Prepare(const PointCorrespondence& correspondence, const MotionOptions& options);

}  // namespace plslam
