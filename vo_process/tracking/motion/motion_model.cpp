// SPDX-License-Identifier: BSD-3-Clause
#include "vo_process/tracking/motion/motion_model.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>

#include "core/geometry/symmetric.h"

namespace plslam::vo {
namespace {

// Largest interval over which constant velocity is extrapolated, relative to the interval of its measurement.
constexpr double kMaxExtrapolation = 2.0;
// Sigmas of the accelerations of a camera.
constexpr double kAcceleration_m_s2 = 10.0;
constexpr double kAcceleration_rad_s2 = 20.0;
// Sigmas of the unknown initial velocity: a car on a motorway, a rotating hand-held camera.
constexpr double kAnySpeed_m_s = 30.0;
constexpr double kAnyTurn_rad_s = 2.0;
// Sigma of rotation above which a prediction is useless.
constexpr double kAnyRotation_rad = 1.0;

Eigen::Vector2d ExtentOf(const Vector6d& twist) { return {twist.head<3>().norm(), twist.tail<3>().norm()}; }

Matrix6d Isotropic(const Eigen::Vector2d& variances) {
  Vector6d diagonal;
  diagonal << Eigen::Vector3d::Constant(variances.x()), Eigen::Vector3d::Constant(variances.y());
  return diagonal.asDiagonal();
}

}  // namespace

double SquaredDeviation(const MotionPrediction& prediction, const SE3& T_odom_predicted, const SE3& T_odom_c) {
  const Vector6d off = (T_odom_predicted.Inverse() * T_odom_c).Log();
  return SquaredMahalanobis<6>(off, prediction.covariance);
}

double MotionModel::Horizon_s(double dt_s) const { return std::min(dt_s, kMaxExtrapolation * last_dt_s_); }

MotionModel::Extent MotionModel::PositionUncertaintyAfter(double dt_s) const {
  return left_behind_ + dt_s * speed_ - Horizon_s(dt_s) * ExtentOf(velocity_);
}

MotionPrediction MotionModel::Predict(double dt_s) const {
  const double before_s = unmeasured_s_;
  const double after_s = unmeasured_s_ + dt_s;
  const Extent acceleration(kAcceleration_m_s2, kAcceleration_rad_s2);
  const Extent accelerated = 0.5 * dt_s * dt_s * acceleration;
  // Difference of (a t^2 / 2)^2 between end and beginning, because an acceleration persists: its effect grows as t^2.
  const Extent since = 0.25 * (std::pow(after_s, 4) - std::pow(before_s, 4)) * acceleration.cwiseAbs2();
  const Extent behind = PositionUncertaintyAfter(dt_s).cwiseAbs2() - left_behind_.cwiseAbs2();
  MotionPrediction prediction;
  prediction.T_prev_c = SE3::Exp(velocity_ * Horizon_s(dt_s));
  prediction.covariance = Isotropic(since + behind.cwiseMax(0.0));
  const double squares = after_s * after_s - before_s * before_s;
  if (last_dt_s_ > 0.0) {
    prediction.covariance += squares / (last_dt_s_ * last_dt_s_) * motion_covariance_;
  } else {
    prediction.covariance += Isotropic(squares * Extent(kAnySpeed_m_s, kAnyTurn_rad_s).cwiseAbs2());
  }
  prediction.is_near = unmeasured_s_ == 0.0 && accelerated.y() < kAnyRotation_rad;
  prediction.is_reliable = prediction.is_near && dt_s <= kMaxExtrapolation * last_dt_s_;
  return prediction;
}

void MotionModel::Observe(const SE3& T_prev_c, double dt_s, const Matrix6d& covariance) {
  velocity_ = T_prev_c.Log() / dt_s;
  last_dt_s_ = dt_s;
  motion_covariance_ = covariance;
  speed_ = ExtentOf(velocity_);
  unmeasured_s_ = 0.0;
  left_behind_.setZero();
}

void MotionModel::Slow(double dt_s) {
  left_behind_ = PositionUncertaintyAfter(dt_s);
  unmeasured_s_ += dt_s;
  velocity_ *= 0.5;
}

}  // namespace plslam::vo
