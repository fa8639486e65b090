// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <cstdint>
#include <vector>

#include "core/geometry/imu.h"
#include "core/geometry/se3.h"

namespace plslam::test {

/// A motion of sinusoids in all six degrees of freedom, with its exact derivatives. Gravity points along -z.
struct SmoothMotion {
  static constexpr double kGravity = 9.81;

  Eigen::Vector3d Position(double t) const {
    return {0.3 * std::sin(1.1 * t) + speed_m_s * t, 0.2 * std::sin(1.7 * t + 0.4), 0.1 * std::cos(2.3 * t)};
  }
  Eigen::Vector3d Velocity(double t) const {
    return {0.33 * std::cos(1.1 * t) + speed_m_s, 0.34 * std::cos(1.7 * t + 0.4), -0.23 * std::sin(2.3 * t)};
  }
  Eigen::Vector3d Acceleration(double t) const {
    return {-0.363 * std::sin(1.1 * t), -0.578 * std::sin(1.7 * t + 0.4), -0.529 * std::cos(2.3 * t)};
  }
  /// A rotation about z by `a` after one about x by `b`.
  double a(double t) const { return 0.5 * std::sin(0.9 * t); }
  double b(double t) const { return 0.3 * std::sin(1.3 * t + 0.2); }
  Eigen::Quaterniond Rotation(double t) const {
    return Eigen::Quaterniond(Eigen::AngleAxisd(a(t), Eigen::Vector3d::UnitZ()) *
                              Eigen::AngleAxisd(b(t), Eigen::Vector3d::UnitX()));
  }
  Eigen::Vector3d Rate(double t) const {
    const double da = 0.45 * std::cos(0.9 * t), db = 0.39 * std::cos(1.3 * t + 0.2);
    return {db, da * std::sin(b(t)), da * std::cos(b(t))};
  }
  Eigen::Vector3d Force(double t) const {
    return Rotation(t).conjugate() * (Acceleration(t) + Eigen::Vector3d(0.0, 0.0, kGravity));
  }
  SE3 Pose(double t) const { return {Rotation(t), Position(t)}; }

  std::vector<ImuSample> Samples(double rate_hz, double from_s, double to_s) const {
    std::vector<ImuSample> samples;
    const auto n = std::llround((to_s - from_s) * rate_hz);
    for (int64_t i = 0; i <= n; ++i) {
      const double t = from_s + static_cast<double>(i) / rate_hz;
      samples.push_back({std::llround(t * 1e9), Rate(t), Force(t)});
    }
    return samples;
  }

  double speed_m_s = 0.0;
};

}  // namespace plslam::test
