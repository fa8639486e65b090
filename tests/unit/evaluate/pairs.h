// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <vector>

#include "core/accuracy/association.h"

namespace plslam::evaluate {

inline SE3 Translation(double x, double y, double z) {
  return {Eigen::Quaterniond::Identity(), Eigen::Vector3d(x, y, z)};
}

/// Twist of one frame: mostly forward, a little of everything else.
inline SE3 SomeMotion(int i) {
  Vector6d x;
  x << 0.02 * std::sin(i), 0.01 * std::cos(3 * i), 0.8, 0.01 * std::sin(0.1 * i), 0.03 * std::cos(0.05 * i), 0.005;
  return SE3::Exp(x);
}

/// A winding path at 10 Hz.
inline Trajectory SomePath(int n) {
  Trajectory path;
  SE3 T = SE3::Exp((Vector6d() << 1, 2, 3, 0.4, 0.5, 0.6).finished());
  for (int i = 0; i < n; ++i) {
    path.push_back({i * 100'000'000LL, T});
    T = T * SomeMotion(i);
  }
  return path;
}

inline PosePairs Pair(const Trajectory& estimate, const Trajectory& truth) {
  PosePairs pairs;
  for (size_t i = 0; i < truth.size(); ++i) {
    pairs.push_back({truth[i].t_ns, estimate[i].T_a_b, truth[i].T_a_b, static_cast<int>(i)});
  }
  return pairs;
}

/// The truth with `drift` appended to each of its motions.
inline Trajectory WithDrift(const Trajectory& truth, const SE3& drift) {
  Trajectory estimate{truth[0]};
  for (size_t i = 1; i < truth.size(); ++i) {
    const SE3 motion = truth[i - 1].T_a_b.Inverse() * truth[i].T_a_b;
    estimate.push_back({truth[i].t_ns, estimate.back().T_a_b * motion * drift});
  }
  return estimate;
}

}  // namespace plslam::evaluate
