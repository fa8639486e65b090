// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "core/geometry/se3.h"
#include "vo_process/options.h"

namespace plslam::vo {

/// What is expected before looking: motion since the last frame, T_prev_c, with the covariance of its right
/// perturbation.
struct MotionPrediction {
  SE3 T_prev_c;
  Matrix6d covariance = Matrix6d::Identity();
  /// The frame before was measured, and so lately that its motion says where to look: the motion goes on.
  bool goes_on = false;
  /// The frame before was measured, and since then the camera cannot have turned anywhere.
  bool is_near = false;
  /// By the robot's own odometry (`RobotMotionModel`), not by constant velocity.
  bool by_robot = false;
};

/// Expected motions (all but one in 3000, 6 degrees of freedom) have less of `SquaredDeviation`.
inline constexpr double kExpectedChi2 = 25.0;

/// How far a pose is from the predicted one, in standard deviations of the prediction, squared.
double SquaredDeviation(const MotionPrediction& prediction, const SE3& T_odom_predicted, const SE3& T_odom_c);

/// Constant velocity. Uncertain is how fast the camera was, what it was accelerated by since, and what of its motion
/// is not gone on with: across gaps and while lost, all of these last, so sigmas grow with the time since the
/// last measured frame, and covariances of one frame after the other add up to that.
class MotionModel {
 public:
  explicit MotionModel(const TrackingOptions& options) : options_(options) {}

  /// `dt_s` > 0. Across a gap much longer than the last interval the velocity is not trusted to go on.
  MotionPrediction Predict(double dt_s) const;

  /// Learns from a measured motion, with the covariance of its right perturbation.
  void Observe(const SE3& T_prev_c, double dt_s, const Matrix6d& covariance);

  /// How fast the camera is is not known any more.
  void Forget() { *this = MotionModel(options_); }

  /// A motion has been measured, so that predictions say more than "anywhere near".
  bool knows_motion() const { return last_dt_s_ > 0.0; }

  /// After a frame that was not measured, `dt_s` behind the one before: half the velocity, so that a lost camera does
  /// not fly away.
  void Slow(double dt_s);

  /// All that it goes on with, for `core/io/files/archive.h`.
  template <class Archive, class Self>
  static void Fields(Archive& a, Self& self) {
    a(self.velocity_, self.last_dt_s_, self.motion_covariance_, self.speed_, self.unmeasured_s_, self.left_behind_);
  }

 private:
  /// Metres and radians, a second or in all.
  using Extent = Eigen::Vector2d;

  Extent LeftBehindAfter(double dt_s) const;
  double Horizon_s(double dt_s) const;

  TrackingOptions options_;
  Vector6d velocity_ = Vector6d::Zero();
  /// Of the motion measured last.
  double last_dt_s_ = 0.0;
  Matrix6d motion_covariance_ = Matrix6d::Zero();
  Extent speed_ = Extent::Zero();
  /// Since the last measured frame, and how much more the camera would have moved since, at its speed, than was
  /// predicted.
  double unmeasured_s_ = 0.0;
  Extent left_behind_ = Extent::Zero();
};

}  // namespace plslam::vo
