// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>

namespace plslam {

/// Covariance in a of a vector whose covariance in b is known.
inline Eigen::Matrix3d RotateCovariance(const Eigen::Matrix3d& R_a_b, const Eigen::Matrix3d& covariance_b) {
  return R_a_b * covariance_b * R_a_b.transpose();
}

}  // namespace plslam
