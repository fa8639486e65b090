// SPDX-License-Identifier: BSD-3-Clause
#include "core/inertial/inertial_filter.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "core/geometry/symmetric.h"

namespace plslam {
namespace {

using Covariance = InertialFilter::Covariance;

// Indices of the error state.
constexpr int kP = 0, kR = 3, kV = 6, kBg = InertialFilter::kRateBias, kBa = InertialFilter::kForceBias, kG = 15;

// Prior sigmas: any vehicle; gyroscopes are off by up to 5 deg/s before they are calibrated (EuRoC's by 4.7),
// accelerometers by 0.015 g; the first mean specific force contains the acceleration.
constexpr double kAnySpeed_m_s = 30.0;
constexpr double kGyroBias_rad_s = 0.1;
constexpr double kAccelerometerBias_m_s2 = 0.15;
constexpr double kFirstGravity_m_s2 = 4.0;
// Sigmas that return to velocity and biases at a new beginning with the earlier bias.
constexpr double kKeptGyroBias_rad_s = 0.005;
constexpr double kKeptAccelerometerBias_m_s2 = 0.1;
// Sigma of gravity below which its direction is known well enough for its magnitude: the curvature of the sphere then
// costs 2 mm/s^2.
constexpr double kRoughGravity_m_s2 = 0.35;
// Sigma of the magnitude: latitude, and the scale error of accelerometers.
constexpr double kMagnitude_m_s2 = 0.03;

Eigen::Vector3d RotationLog(const Eigen::Quaterniond& q) { return SE3(q, Eigen::Vector3d::Zero()).Log().tail<3>(); }

double Square(double x) { return x * x; }

void SetBlock(Covariance& P, int i, double sigma) {
  P.block<3, 3>(i, i) = Square(sigma) * Eigen::Matrix3d::Identity();
}

void Symmetrise(Covariance& P) { P = (0.5 * (P + P.transpose())).eval(); }

/// Derivative of the next error state with respect to this one (`F`), and the noise in between.
struct Step {
  Covariance F = Covariance::Identity();
  Covariance Q = Covariance::Zero();
};

Step StepOf(const Preintegration& motion, const Eigen::Matrix3d& R, const ImuNoise& noise, const ImuBias& bias) {
  const double t = motion.dt_s();
  const Preintegration::Jacobians& J = motion.jacobians();
  const Eigen::Matrix3d I = Eigen::Matrix3d::Identity();
  Step step;
  Covariance& F = step.F;
  F.block<3, 3>(kP, kV) = t * I;
  F.block<3, 3>(kP, kG) = 0.5 * t * t * I;
  F.block<3, 3>(kP, kR) = -R * Skew(motion.PositionWith(bias));
  F.block<3, 3>(kP, kBg) = R * J.p_rate;
  F.block<3, 3>(kP, kBa) = R * J.p_force;
  F.block<3, 3>(kR, kR) = motion.RotationWith(bias).toRotationMatrix().transpose();
  F.block<3, 3>(kR, kBg) = J.R_rate;
  F.block<3, 3>(kV, kG) = t * I;
  F.block<3, 3>(kV, kR) = -R * Skew(motion.VelocityWith(bias));
  F.block<3, 3>(kV, kBg) = R * J.v_rate;
  F.block<3, 3>(kV, kBa) = R * J.v_force;
  // [rotation; dv; dp] of the motion to the error state.
  Eigen::Matrix<double, InertialFilter::kSize, 9> G = Eigen::Matrix<double, InertialFilter::kSize, 9>::Zero();
  G.block<3, 3>(kR, 0) = I;
  G.block<3, 3>(kV, 3) = R;
  G.block<3, 3>(kP, 6) = R;
  step.Q = G * motion.covariance() * G.transpose();
  step.Q.block<3, 3>(kBg, kBg) += Square(noise.gyroscope_walk_rad_s2_sqrt_hz) * t * I;
  step.Q.block<3, 3>(kBa, kBa) += Square(noise.accelerometer_walk_m_s3_sqrt_hz) * t * I;
  return step;
}

}  // namespace

void InertialFilter::Begin(const SE3& T_odom_imu, const Matrix6d& covariance, const Eigen::Vector3d& force_m_s2,
                           bool keeps_bias) {
  keeps_bias = keeps_bias && has_begun_;
  const ImuBias bias = keeps_bias ? state_.bias : ImuBias();
  state_ = InertialState();
  state_.T_odom_imu = T_odom_imu;
  state_.bias = bias;
  const Eigen::Vector3d up = T_odom_imu.rotation() * (force_m_s2 - bias.force_m_s2);
  const double norm = up.norm();
  if (norm > 0.0) state_.gravity_m_s2 = -kGravity_m_s2 / norm * up;
  P_.setZero();
  P_.topLeftCorner<6, 6>() = Rotated(covariance);
  SetBlock(P_, kV, kAnySpeed_m_s);
  SetBlock(P_, kBg, keeps_bias ? kKeptGyroBias_rad_s : kGyroBias_rad_s);
  SetBlock(P_, kBa, keeps_bias ? kKeptAccelerometerBias_m_s2 : kAccelerometerBias_m_s2);
  SetBlock(P_, kG, kFirstGravity_m_s2);
  has_begun_ = true;
  knows_magnitude_ = false;
  MeasureFromHere();
}

void InertialFilter::ContinueAt(const SE3& T_odom_imu, const Matrix6d& covariance, double unknown_s) {
  state_.T_odom_imu = T_odom_imu;
  state_.velocity_m_s.setZero();
  P_.topRows<kRateBias>().setZero();
  P_.leftCols<kRateBias>().setZero();
  P_.topLeftCorner<6, 6>() = Rotated(covariance);
  SetBlock(P_, kV, kAnySpeed_m_s);
  const Eigen::Matrix3d I = Eigen::Matrix3d::Identity();
  P_.block<3, 3>(kBg, kBg) += Square(noise_.gyroscope_walk_rad_s2_sqrt_hz) * unknown_s * I;
  P_.block<3, 3>(kBa, kBa) += Square(noise_.accelerometer_walk_m_s3_sqrt_hz) * unknown_s * I;
  MeasureFromHere();
}

double InertialFilter::VelocitySigma() const { return std::sqrt(P_.diagonal().segment<3>(kV).maxCoeff()); }

/// Covariance of [position in odom; rotation] from that of a right perturbation of the pose.
Matrix6d InertialFilter::Rotated(const Matrix6d& covariance) const {
  Matrix6d A = Matrix6d::Identity();
  A.topLeftCorner<3, 3>() = state_.T_odom_imu.R();
  return A * covariance * A.transpose();
}

void InertialFilter::Propagate(const Preintegration& motion) {
  const Eigen::Quaterniond q = state_.T_odom_imu.rotation();
  const Step step = StepOf(motion, q.toRotationMatrix(), noise_, state_.bias);
  const double t = motion.dt_s();
  const Eigen::Vector3d p = state_.T_odom_imu.translation() + t * state_.velocity_m_s +
                            0.5 * t * t * state_.gravity_m_s2 + q * motion.PositionWith(state_.bias);
  state_.velocity_m_s += t * state_.gravity_m_s2 + q * motion.VelocityWith(state_.bias);
  state_.T_odom_imu = SE3(q * motion.RotationWith(state_.bias), p);
  P_ = (step.F * P_ * step.F.transpose() + step.Q).eval();
  P_since_ = (step.F * P_since_ * step.F.transpose() + step.Q).eval();
  Symmetrise(P_);
  Symmetrise(P_since_);
}

Vector6d InertialFilter::Residual(const SE3& T_odom_imu) const {
  Vector6d residual;
  residual << T_odom_imu.translation() - state_.T_odom_imu.translation(),
      RotationLog(state_.T_odom_imu.rotation().conjugate() * T_odom_imu.rotation());
  return residual;
}

InertialFilter::Agreement InertialFilter::AgreementWith(const SE3& T_odom_imu, const Matrix6d& covariance) const {
  const Matrix6d N = Rotated(covariance);
  const Matrix6d S = P_.topLeftCorner<6, 6>() + N;
  const Vector6d residual = Residual(T_odom_imu);
  const auto factors = S.ldlt();
  const auto log_determinant = [](const auto& ldlt) { return ldlt.vectorD().array().abs().log().sum(); };
  const double innovation = residual.dot(factors.solve(residual));
  return {innovation, innovation + log_determinant(factors) - log_determinant(N.ldlt())};
}

void InertialFilter::Update(const SE3& T_odom_imu, const Matrix6d& covariance) {
  const Matrix6d N = Rotated(covariance);
  const Matrix6d S = P_.topLeftCorner<6, 6>() + N;
  const Eigen::Matrix<double, kSize, 6> K = S.ldlt().solve(P_.topRows<6>()).transpose();
  const Error d = K * Residual(T_odom_imu);
  Covariance A = Covariance::Identity();
  A.leftCols<6>() -= K;
  P_ = (A * P_ * A.transpose() + K * N * K.transpose()).eval();
  Symmetrise(P_);
  Correct(d);
  UseMagnitude();
}

void InertialFilter::Drift(const Eigen::Matrix3d& covariance) {
  const Eigen::Matrix3d A = Skew(state_.gravity_m_s2) * state_.T_odom_imu.R();
  P_.block<3, 3>(kG, kG) += A * covariance * A.transpose();
  Symmetrise(P_);
}

void InertialFilter::StandStill(double sigma_m_s) {
  const Eigen::Matrix3d N = Square(sigma_m_s) * Eigen::Matrix3d::Identity();
  const Eigen::Matrix3d S = P_.block<3, 3>(kV, kV) + N;
  const Eigen::Matrix<double, kSize, 3> K = S.ldlt().solve(P_.middleRows<3>(kV)).transpose();
  const Error d = -K * state_.velocity_m_s;
  Covariance A = Covariance::Identity();
  A.middleCols<3>(kV) -= K;
  for (Covariance* const P : {&P_, &P_since_}) {
    *P = (A * *P * A.transpose() + K * N * K.transpose()).eval();
    Symmetrise(*P);
  }
  Correct(d);
}

void InertialFilter::Correct(const Error& d) {
  state_.T_odom_imu = SE3(state_.T_odom_imu.rotation() * ExpSO3(d.segment<3>(kR)),
                          state_.T_odom_imu.translation() + d.segment<3>(kP));
  state_.velocity_m_s += d.segment<3>(kV);
  state_.bias.rate_rad_s += d.segment<3>(kBg);
  state_.bias.force_m_s2 += d.segment<3>(kBa);
  state_.gravity_m_s2 += d.segment<3>(kG);
}

void InertialFilter::UseMagnitude() {
  if (knows_magnitude_ || std::sqrt(P_.diagonal().tail<3>().maxCoeff()) > kRoughGravity_m_s2) return;
  knows_magnitude_ = true;
  Eigen::Matrix<double, 1, kSize> H = Eigen::Matrix<double, 1, kSize>::Zero();
  H.tail<3>() = state_.gravity_m_s2.normalized().transpose();
  const double variance = (H * P_ * H.transpose())(0) + Square(kMagnitude_m_s2);
  const Error K = P_ * H.transpose() / variance;
  const Error d = K * (kGravity_m_s2 - state_.gravity_m_s2.norm());
  const Covariance A = Covariance::Identity() - K * H;
  P_ = (A * P_ * A.transpose() + Square(kMagnitude_m_s2) * K * K.transpose()).eval();
  Symmetrise(P_);
  Correct(d);
}

std::optional<UpDirection> InertialFilter::Up() const {
  if (!has_begun_ || !knows_magnitude_) return std::nullopt;
  const Eigen::Matrix3d R_imu_odom = state_.T_odom_imu.R().transpose();
  const Eigen::Vector3d up = -state_.gravity_m_s2.normalized();
  const Eigen::Vector3d up_imu = R_imu_odom * up;
  // An error of gravity along itself does not turn it.
  Eigen::Matrix<double, 3, kSize> J = Eigen::Matrix<double, 3, kSize>::Zero();
  J.middleCols<3>(kR) = Skew(up_imu);
  J.middleCols<3>(kG) =
      -R_imu_odom * (Eigen::Matrix3d::Identity() - up * up.transpose()) / state_.gravity_m_s2.norm();
  const auto [values, vectors] = EigenOf<3>(J * P_ * J.transpose());
  return UpDirection{up_imu, std::sqrt(std::max(values.maxCoeff(), 0.0))};
}

void InertialFilter::MeasureFromHere() {
  T_odom_origin_ = state_.T_odom_imu;
  P_since_ = P_;
  P_since_.topRows<6>().setZero();
  P_since_.leftCols<6>().setZero();
}

Matrix6d InertialFilter::MotionCovariance() const {
  Matrix6d A = Matrix6d::Identity();
  A.topLeftCorner<3, 3>() = state_.T_odom_imu.R().transpose();
  return A * P_since_.topLeftCorner<6, 6>() * A.transpose();
}

}  // namespace plslam
