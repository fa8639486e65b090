// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>

#include <Eigen/Core>

namespace plslam {

/// The vertical as an inertial sensor measures it.
struct UpDirection {
  /// Against gravity, in the frame of the sensor or camera; unit length.
  Eigen::Vector3d direction = -Eigen::Vector3d::UnitY();
  /// Sigma of each of its two angles; positive.
  double sigma_rad = 1.0;

  bool IsValid() const {
    return std::abs(direction.norm() - 1.0) < 1e-6 && sigma_rad > 0.0 && std::isfinite(sigma_rad);
  }

  template <class Archive, class Self>
  static void Fields(Archive& a, Self& self) {
    a(self.direction, self.sigma_rad);
  }
};

}  // namespace plslam
