// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <cstdint>

#include "core/geometry/se3.h"

namespace plslam::test {

inline constexpr int64_t kFrame_ns = 50'000'000;

/// A turning way through a `FeatureWorld`, 0.2 m/s at `kFrame_ns`: T_w_c of a frame, or between two.
inline SE3 PathAt(double frame) {
  const double s = 0.02 * frame;
  return SE3(ExpSO3(Eigen::Vector3d(0.05 * std::sin(s), 0.3 * s, 0.0)),
             Eigen::Vector3d(0.5 * std::sin(s), 0.1 * s, 0.8 * (1.0 - std::cos(s))));
}

}  // namespace plslam::test
