// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <numbers>

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace plslam {

inline constexpr double kRadPerDeg = std::numbers::pi / 180.0;

using Vector6d = Eigen::Matrix<double, 6, 1>;
using Matrix6d = Eigen::Matrix<double, 6, 6>;

/// Rigid transform. `T_a_b` takes points of frame b to frame a: `p_a = T_a_b * p_b`; neighbouring letters cancel:
/// `T_a_b * T_b_c` is `T_a_c`.
///
/// Tangent vectors are [translation_m; rotation_rad], and perturbations act on the right: `T * Exp(x)`, with x in the
/// frame on the right (b). All covariances of poses in this project follow that convention.
class SE3 {
 public:
  SE3() = default;
  SE3(const Eigen::Quaterniond& q, const Eigen::Vector3d& t) : q_(q.normalized()), t_(t) {}
  SE3(const Eigen::Matrix3d& R, const Eigen::Vector3d& t) : SE3(Eigen::Quaterniond(R), t) {}

  /// Keeps the bits of `q`, which must have unit norm up to rounding.
  static SE3 FromUnit(const Eigen::Quaterniond& q, const Eigen::Vector3d& t) {
    SE3 T;
    T.q_ = q;
    T.t_ = t;
    return T;
  }

  const Eigen::Quaterniond& rotation() const { return q_; }
  const Eigen::Vector3d& translation() const { return t_; }
  Eigen::Matrix3d R() const { return q_.toRotationMatrix(); }
  Eigen::Matrix4d matrix() const;

  SE3 Inverse() const;
  SE3 operator*(const SE3& other) const { return SE3(q_ * other.q_, t_ + q_ * other.t_); }
  Eigen::Vector3d operator*(const Eigen::Vector3d& p) const { return q_ * p + t_; }

  /// Exponential of [translation; rotation] and its inverse (rotation angle in [0, pi]). Exact at and near zero.
  static SE3 Exp(const Vector6d& x);
  Vector6d Log() const;

  /// `T * Exp(x) == Exp(T.Adjoint() * x) * T`.
  Matrix6d Adjoint() const;

  /// Whether it contains no NaN and no infinity.
  bool IsFinite() const { return q_.coeffs().allFinite() && t_.allFinite(); }

 private:
  Eigen::Quaterniond q_ = Eigen::Quaterniond::Identity();
  Eigen::Vector3d t_ = Eigen::Vector3d::Zero();
};

/// [v]x, so that `Skew(v) * u == v.cross(u)`.
Eigen::Matrix3d Skew(const Eigen::Vector3d& v);

/// Exponential of so(3).
Eigen::Quaterniond ExpSO3(const Eigen::Vector3d& w);

/// Covariance of the inverse of a motion, both right perturbations: `Ad(T_a_b) cov_ab Ad(T_a_b)^T`.
Matrix6d InverseCovariance(const SE3& T_a_b, const Matrix6d& cov_ab);

/// Covariance of `T_a_b * T_b_c` from those of its independent factors, to first order (PL-SLAM §IV.D):
/// `Ad(T_b_c^-1) cov_ab Ad(T_b_c^-1)^T + cov_bc`.
Matrix6d ComposeCovariance(const Matrix6d& cov_ab, const SE3& T_b_c, const Matrix6d& cov_bc);

}  // namespace plslam
