// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include <Eigen/Core>

#include "vo_process/stereo/row_field.h"

namespace plslam::vo {

/// What a tracker has learned of its cameras while driving and believes; what another one of the same cameras may
/// begin with.
struct SelfCalibration {
  struct Rows {
    RowField::Coefficients offsets_px = RowField::Coefficients::Zero();
    Eigen::Matrix<double, 6, 6> covariance_px2 = Eigen::Matrix<double, 6, 6>::Zero();
  };
  /// Of b0 + b1 x + b2 x^2 (`DisparityCalibration`).
  struct Disparities {
    Eigen::Vector3d coefficients_px = Eigen::Vector3d::Zero();
    Eigen::Matrix3d covariance_px2 = Eigen::Matrix3d::Zero();
  };
  /// nullopt: nothing that is believed.
  std::optional<Rows> rows;
  std::optional<Disparities> disparities;
};

}  // namespace plslam::vo
