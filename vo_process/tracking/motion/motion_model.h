// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include "core/geometry/se3.h"

namespace plslam::vo {

/// Predicted motion since the last frame, T_prev_c, with the covariance of its right perturbation.
struct MotionPrediction {
  SE3 T_prev_c;
  Matrix6d covariance = Matrix6d::Identity();
  /// Whether the previous frame was measured, so recently that its motion continues.
  bool is_reliable = false;
  /// Whether the previous frame was measured, so recently that the camera cannot have turned arbitrarily.
  bool is_near = false;
  /// Whether it is based on the robot's own odometry (`RobotMotionModel`) or inertial sensor (`InertialMotionModel`), not
  /// on constant velocity.
  bool by_robot = false;
  /// Covariance of the motion since the last measured frame, if the sensor carried the pose of the last frame.
  std::optional<Matrix6d> since_measured{};

  /// The same for the search of landmarks, from a previous pose that may be carried.
  MotionPrediction ForSearch() const {
    MotionPrediction prediction = *this;
    if (since_measured) prediction.covariance = *since_measured;
    return prediction;
  }
};

/// Bound on `SquaredDeviation` of expected motions (all but one in 3000, 6 degrees of freedom).
inline constexpr double kExpectedChi2 = 25.0;

/// Returns the squared Mahalanobis distance of a pose from the predicted one.
double SquaredDeviation(const MotionPrediction& prediction, const SE3& T_odom_predicted, const SE3& T_odom_c);

/// Constant velocity. The covariance includes the uncertainty of the velocity, accelerations since, and the part of the
/// motion that was not extrapolated. Across gaps and while lost these persist, so sigmas grow with the time since the
/// last measured frame, and the covariances of consecutive frames add up to that.
class MotionModel {
 public:
  /// `dt_s` > 0. Across a gap much longer than the last interval the velocity is not extrapolated fully.
  MotionPrediction Predict(double dt_s) const;

  /// Updates the velocity from a measured motion, with the covariance of its right perturbation.
  void Observe(const SE3& T_prev_c, double dt_s, const Matrix6d& covariance);

  /// Discards the velocity.
  void Forget() { *this = MotionModel(); }

  /// Whether a motion was measured, so that predictions are informative.
  bool knows_motion() const { return last_dt_s_ > 0.0; }

  /// Halves the velocity after a frame that was not measured, `dt_s` after the previous one, so that a lost camera does
  /// not drift away.
  void Slow(double dt_s);

  /// The state between frames, for `core/files/archive.h`.
  template <class Archive, class Self>
  static void Fields(Archive& a, Self& self) {
    a(self.velocity_, self.last_dt_s_, self.motion_covariance_, self.speed_, self.unmeasured_s_, self.left_behind_);
  }

 private:
  /// [metres, radians], per second or in total.
  using Extent = Eigen::Vector2d;

  Extent PositionUncertaintyAfter(double dt_s) const;
  double Horizon_s(double dt_s) const;

  Vector6d velocity_ = Vector6d::Zero();
  /// Interval and covariance of the last measured motion.
  double last_dt_s_ = 0.0;
  Matrix6d motion_covariance_ = Matrix6d::Zero();
  Extent speed_ = Extent::Zero();
  /// Time since the last measured frame, and the motion since then, at the measured speed, that was not predicted.
  double unmeasured_s_ = 0.0;
  Extent left_behind_ = Extent::Zero();
};

}  // namespace plslam::vo
