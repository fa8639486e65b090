// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <numbers>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "core/optim/pose_graph/pose_graph.h"

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

/// All that differs between pose graphs in space and in the plane. Perturbations stand on the right, to first order
/// [translation; rotation].
template <class Pose>
struct PoseGroup;

/// Error of an edge and its derivatives by the right perturbations of the poses.
template <class Pose>
struct PoseEdgeError {
  Eigen::Matrix<double, kPoseFreedom<Pose>, 1> e;
  PoseMatrix<Pose> by_a;
  PoseMatrix<Pose> by_b;
};

template <>
struct PoseGroup<SE3> {
  static constexpr int kDimension = 3;

  static SE3 Plus(const SE3& pose, const double* step);
  static SE3 FromRotation(const Eigen::Matrix3d& R, const Eigen::Vector3d& t) { return SE3(R, t); }
  static PoseEdgeError<SE3> Error(const SE3& T_a_b, const SE3& a, const SE3& b);
};

template <>
struct PoseGroup<SE2> {
  static constexpr int kDimension = 2;

  static SE2 Plus(const SE2& pose, const double* step);
  static SE2 FromRotation(const Eigen::Matrix2d& R, const Eigen::Vector2d& t) {
    return SE2(std::atan2(R(1, 0), R(0, 0)), t);
  }
  static PoseEdgeError<SE2> Error(const SE2& T_a_b, const SE2& a, const SE2& b);
};

/// e^T information e.
template <class Pose>
double EdgeChi2(const PoseGraphMotion<Pose>& edge, const std::vector<Pose>& T_w_kf) {
  const auto e = PoseGroup<Pose>::Error(edge.T_a_b, T_w_kf[edge.a], T_w_kf[edge.b]).e;
  return e.dot(edge.information * e);
}

}  // namespace plslam
