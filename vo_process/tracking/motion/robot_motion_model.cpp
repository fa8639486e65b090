// SPDX-License-Identifier: BSD-3-Clause
#include "vo_process/tracking/motion/robot_motion_model.h"

#include <Eigen/Cholesky>
#include <cmath>

#include "core/geometry/symmetric.h"

namespace plslam::vo {
namespace {

// Relative error of distances and rotations by wheels: worn or soft tyres, skidding in curves.
constexpr double kWheelShare = 0.05;
// Spurious rotation rate of wheels and simple gyros, as on a road that is not flat.
constexpr double kWheelDrift_rad_s = 1.0 * kRadPerDeg;
// Errors however short the motion: the ground tilts the body, which wheels do not measure, and time stamps are off by
// some milliseconds.
constexpr double kGround_m = 0.005;
constexpr double kGround_rad = 1.0 * kRadPerDeg;
// Interval over which robot and images are compared: long enough for slipping wheels to exceed the ground's share.
constexpr double kComparison_s = 0.5;

Matrix6d Squares(double translation_m, double rotation_rad) {
  Vector6d sigma;
  sigma << Eigen::Vector3d::Constant(translation_m), Eigen::Vector3d::Constant(rotation_rad);
  return sigma.cwiseAbs2().asDiagonal();
}

bool AreAlike(const SE3& a, const SE3& b, const Matrix6d& covariance) {
  const Vector6d off = (a.Inverse() * b).Log();
  return SquaredMahalanobis<6>(off, covariance) < kExpectedChi2;
}

}  // namespace

RobotMotionModel::Extent RobotMotionModel::After(Extent extent, double dt_s) const {
  extent.time_s += dt_s;
  if (!motion_) return extent;
  const SE3 T_prevb_b = motion_->T_b_c * FromPrevious() * motion_->T_b_c.Inverse();
  extent.way_m += T_prevb_b.translation().norm();
  extent.turn_rad += T_prevb_b.Log().tail<3>().norm();
  return extent;
}

SE3 RobotMotionModel::FromPrevious() const {
  return motion_->is_from_previous ? motion_->OfCamera() : T_seen_prev_.Inverse() * motion_->OfCamera();
}

int64_t RobotMotionModel::MeasuredAt(int64_t prev_t_ns) const {
  // Unsigned: time stamps may have any value.
  return static_cast<int64_t>(static_cast<uint64_t>(prev_t_ns) -
                              static_cast<uint64_t>(std::llround(1e9 * unseen_.time_s)));
}

/// Covariance of the camera's motion; the body rotates about its own origin. Zero for no time.
Matrix6d RobotMotionModel::Covariance(const Extent& extent) const {
  if (extent.time_s == 0.0) return Matrix6d::Zero();
  const Matrix6d A = motion_->T_b_c.Inverse().Adjoint();
  const double rotation_rad = kGround_rad + kWheelShare * extent.turn_rad + kWheelDrift_rad_s * extent.time_s;
  return A * Squares(kGround_m + kWheelShare * extent.way_m, rotation_rad) * A.transpose();
}

MotionPrediction RobotMotionModel::Predict(const MotionPrediction& own, double dt_s) const {
  if (!motion_ || !agrees_) return own;
  MotionPrediction prediction = own;
  prediction.T_prev_c = FromPrevious();
  prediction.covariance = Covariance(After(unseen_, dt_s)) - Covariance(unseen_);
  prediction.by_robot = true;
  const bool is_possible =
      !own.is_reliable || AreAlike(own.T_prev_c, prediction.T_prev_c, own.covariance + prediction.covariance);
  return is_possible ? prediction : own;
}

void RobotMotionModel::Observe(const SE3& T_prev_c, const Matrix6d& covariance, double dt_s, bool is_sure) {
  if (!motion_ || !is_sure) {
    BeginToCompare();
  } else {
    robot_ = robot_ * FromPrevious();
    camera_ = camera_ * T_prev_c;
    covariance_ = ComposeCovariance(covariance_, T_prev_c, covariance);
    compared_ = After(compared_, dt_s);
  }
  unseen_ = {};
  T_seen_prev_ = SE3();
  if (compared_.time_s < kComparison_s) return;
  agrees_ = AreAlike(robot_, camera_, Covariance(compared_) + covariance_);
  BeginToCompare();
}

void RobotMotionModel::Miss(const SE3& T_prev_c, double dt_s) {
  unseen_ = After(unseen_, dt_s);
  T_seen_prev_ = T_seen_prev_ * T_prev_c;
  BeginToCompare();
}

void RobotMotionModel::BeginToCompare() {
  robot_ = camera_ = SE3();
  covariance_.setZero();
  compared_ = {};
}

}  // namespace plslam::vo
