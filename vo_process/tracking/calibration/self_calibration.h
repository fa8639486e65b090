// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include <Eigen/Core>

#include "vo_process/stereo/row_field.h"

namespace plslam::vo {

/// Self-calibration of a tracker that is in use; another tracker with the same cameras may start with it.
struct SelfCalibration {
  struct Rows {
    RowField::Coefficients offsets_px = RowField::Coefficients::Zero();
    Eigen::Matrix<double, 6, 6> covariance_px2 = Eigen::Matrix<double, 6, 6>::Zero();
  };
  /// Coefficients of b0 + b1 x + b2 x^2 (`DisparityCalibration`).
  struct Disparities {
    Eigen::Vector3d coefficients_px = Eigen::Vector3d::Zero();
    Eigen::Matrix3d covariance_px2 = Eigen::Matrix3d::Zero();
  };
  /// The calibrations; nullopt if none is in use.
  std::optional<Rows> rows;
  std::optional<Disparities> disparities;
};

}  // namespace plslam::vo
