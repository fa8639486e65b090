// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include "core/motion/motion_estimator.h"

namespace plslam {

/// A point ready for `PointBatch`: checked, and weighted as the options say.
struct PreparedPoint {
  Eigen::Vector3d p_ref;
  Eigen::Matrix3d covariance;
  Eigen::Vector3d uvd;
  double sigma_px;
  double sigma_disparity_px;
  bool has_disparity;
};

/// nullopt for what cannot be used: anything not finite, sigmas that are not positive, a position that is unknown.
std::optional<PreparedPoint> Prepare(const PointCorrespondence& correspondence, const MotionOptions& options);

}  // namespace plslam
