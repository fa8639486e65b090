// SPDX-License-Identifier: BSD-3-Clause
#include "core/geometry/se3.h"

#include <cmath>

namespace plslam {
namespace {

// Coefficients of the left Jacobian of SO(3): V = I + b [w]x + c [w]x^2.
struct JacobianCoefficients {
  double b;
  double c;
};

JacobianCoefficients Coefficients(double angle) {
  const double angle2 = angle * angle;
  if (angle < 1e-4) return {0.5 - angle2 / 24.0, 1.0 / 6.0 - angle2 / 120.0};
  return {(1.0 - std::cos(angle)) / angle2, (angle - std::sin(angle)) / (angle2 * angle)};
}

Eigen::Matrix3d LeftJacobian(const Eigen::Vector3d& w) {
  const JacobianCoefficients k = Coefficients(w.norm());
  const Eigen::Matrix3d W = Skew(w);
  return Eigen::Matrix3d::Identity() + k.b * W + k.c * W * W;
}

Eigen::Vector3d LogSO3(const Eigen::Quaterniond& q) {
  const double sign = q.w() < 0.0 ? -1.0 : 1.0;
  const double sine = q.vec().norm();
  if (sine < 1e-9) return 2.0 * sign * q.vec();
  return 2.0 * sign * std::atan2(sine, sign * q.w()) / sine * q.vec();
}

}  // namespace

Eigen::Matrix4d SE3::matrix() const {
  Eigen::Matrix4d m = Eigen::Matrix4d::Identity();
  m.topLeftCorner<3, 3>() = R();
  m.topRightCorner<3, 1>() = t_;
  return m;
}

SE3 SE3::Inverse() const {
  const Eigen::Quaterniond q_inverse = q_.conjugate();
  return SE3(q_inverse, -(q_inverse * t_));
}

SE3 SE3::Exp(const Vector6d& x) {
  const Eigen::Vector3d w = x.tail<3>();
  return SE3(ExpSO3(w), LeftJacobian(w) * x.head<3>());
}

Vector6d SE3::Log() const {
  const Eigen::Vector3d w = LogSO3(q_);
  Vector6d x;
  x << LeftJacobian(w).partialPivLu().solve(t_), w;
  return x;
}

Matrix6d SE3::Adjoint() const {
  const Eigen::Matrix3d rotation = R();
  Matrix6d A = Matrix6d::Zero();
  A.topLeftCorner<3, 3>() = rotation;
  A.topRightCorner<3, 3>() = Skew(t_) * rotation;
  A.bottomRightCorner<3, 3>() = rotation;
  return A;
}

Eigen::Matrix3d Skew(const Eigen::Vector3d& v) {
  Eigen::Matrix3d m;
  m << 0.0, -v.z(), v.y(), v.z(), 0.0, -v.x(), -v.y(), v.x(), 0.0;
  return m;
}

Eigen::Quaterniond ExpSO3(const Eigen::Vector3d& w) {
  const double angle = w.norm();
  const double half = 0.5 * angle;
  // sin(half) / angle, by its series at small angles, where the quotient loses precision.
  const double scale = angle < 1e-4 ? 0.5 - angle * angle / 48.0 : std::sin(half) / angle;
  return Eigen::Quaterniond(std::cos(half), scale * w.x(), scale * w.y(), scale * w.z()).normalized();
}

Matrix6d InverseCovariance(const SE3& T_a_b, const Matrix6d& cov_ab) {
  const Matrix6d A = T_a_b.Adjoint();
  return A * cov_ab * A.transpose();
}

Matrix6d ComposeCovariance(const Matrix6d& cov_ab, const SE3& T_b_c, const Matrix6d& cov_bc) {
  const Matrix6d A = T_b_c.Inverse().Adjoint();
  const Matrix6d sum = A * cov_ab * A.transpose() + cov_bc;
  return 0.5 * (sum + sum.transpose());
}

}  // namespace plslam
