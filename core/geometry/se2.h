// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <numbers>

#include <Eigen/Core>

namespace plslam {

/// Angle in [-pi, pi] that differs from `angle_rad` by whole turns.
inline double WrapAngle(double angle_rad) { return std::remainder(angle_rad, 2.0 * std::numbers::pi); }

/// Rigid transform of the plane; what SE3 is in space. Tangent vectors are [translation_m; rotation_rad].
class SE2 {
 public:
  SE2() = default;
  /// The angle is kept as it is.
  SE2(double angle_rad, const Eigen::Vector2d& t) : angle_(angle_rad), t_(t) {}

  double angle() const { return angle_; }
  const Eigen::Vector2d& translation() const { return t_; }
  Eigen::Matrix2d R() const {
    const double c = std::cos(angle_);
    const double s = std::sin(angle_);
    Eigen::Matrix2d m;
    m << c, -s, s, c;
    return m;
  }

  SE2 Inverse() const { return SE2(-angle_, -(R().transpose() * t_)); }
  SE2 operator*(const SE2& other) const { return SE2(WrapAngle(angle_ + other.angle_), t_ + R() * other.t_); }
  Eigen::Vector2d operator*(const Eigen::Vector2d& p) const { return R() * p + t_; }

  /// No NaN, no infinity.
  bool IsFinite() const { return std::isfinite(angle_) && t_.allFinite(); }

 private:
  double angle_ = 0.0;
  Eigen::Vector2d t_ = Eigen::Vector2d::Zero();
};

}  // namespace plslam
