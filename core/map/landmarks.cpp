// SPDX-License-Identifier: BSD-3-Clause
#include "core/map/landmarks.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace plslam {

void LandmarkCovariance::Set(const Eigen::Matrix3d& covariance) {
  constexpr double kMax = std::numeric_limits<float>::max();
  size_t i = 0;
  for (int row = 0; row < 3; ++row) {
    for (int column = row; column < 3; ++column) {
      const double value = covariance(row, column);
      upper_[i++] = static_cast<float>(std::isfinite(value) ? std::clamp(value, -kMax, kMax) : value);
    }
  }
}

}  // namespace plslam
