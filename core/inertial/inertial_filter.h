// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <optional>

#include <Eigen/Core>

#include "core/geometry/imu.h"
#include "core/geometry/se3.h"
#include "core/geometry/up_direction.h"
#include "core/inertial/preintegration.h"

namespace plslam {

/// Standard gravity, m/s^2; it varies by 0.3 % over the earth.
inline constexpr double kGravity_m_s2 = 9.81;

/// Motion of an inertial sensor in a fixed frame (odom), and what its samples contain besides.
struct InertialState {
  SE3 T_odom_imu;
  Eigen::Vector3d velocity_m_s = Eigen::Vector3d::Zero();
  /// Gravity in odom, pointing down; unlike the frame it is not level.
  Eigen::Vector3d gravity_m_s2 = Eigen::Vector3d::Zero();
  ImuBias bias;

  template <class Archive, class Self>
  static void Fields(Archive& a, Self& self) {
    a(self.T_odom_imu, self.velocity_m_s, self.gravity_m_s2, self.bias);
  }
};

/// Kalman filter of `InertialState` by preintegrated motions and measured poses.
///
/// Stereo poses have a scale, so position, velocity, gravity and accelerometer bias are linear in the poses, and the
/// rotation is nearly linear in the gyroscope bias over an interval between frames: begun with a covariance that says
/// nothing about velocity and gravity, the filter is the recursive form of the linear system over the first frames, and
/// needs no special motion. The magnitude of gravity is used once, as soon as its direction is roughly known.
///
/// Order of the error state: position (odom), rotation (right perturbation), velocity, biases of rate and force,
/// gravity.
class InertialFilter {
 public:
  static constexpr int kSize = 18;
  static constexpr int kRateBias = 9;
  static constexpr int kForceBias = 12;
  using Covariance = Eigen::Matrix<double, kSize, kSize>;

  explicit InertialFilter(const ImuNoise& noise) : noise_(noise) {}

  /// Begins at a measured pose with the covariance of its right perturbation. `force_m_s2` is the mean specific force
  /// around it, a first guess of the vertical. The biases of an earlier interval are kept if `keeps_bias`.
  void Begin(const SE3& T_odom_imu, const Matrix6d& covariance, const Eigen::Vector3d& force_m_s2, bool keeps_bias);

  /// Continues at a measured pose after motions that are not known, which took this long: gravity and biases are still
  /// known.
  void ContinueAt(const SE3& T_odom_imu, const Matrix6d& covariance, double unknown_s);
  /// Largest sigma of a component of the velocity, m/s.
  double VelocitySigma() const;

  /// Moves the state over the interval of a motion, which must have been integrated with about the bias of the state.
  void Propagate(const Preintegration& motion);

  /// Agreement of a measured pose, with the covariance of its right perturbation, with the state.
  struct Agreement {
    double innovation = 0.0;  ///< squared and normalised, of 6 degrees of freedom
    /// Twice the negative logarithm of the ratio of likelihoods of the measurement, by this state and by the measured
    /// pose itself: an inaccurate pose agrees with every state.
    double surprise = 0.0;
  };
  Agreement AgreementWith(const SE3& T_odom_imu, const Matrix6d& covariance) const;
  /// Takes the measured pose.
  void Update(const SE3& T_odom_imu, const Matrix6d& covariance);

  /// Odom has turned, as all odometry drifts, by an angle of this covariance (in the frame of the sensor) since the last
  /// measured pose: gravity is no longer what it was there.
  void Drift(const Eigen::Matrix3d& covariance);

  /// The sensor stands, up to this sigma of its velocity.
  void StandStill(double sigma_m_s);

  /// The vertical in the frame of the sensor, with the larger sigma of its two angles: errors of gravity, and of the
  /// pose's roll and pitch; nullopt until the magnitude of gravity is known.
  std::optional<UpDirection> Up() const;

  /// The biases; the sigma of a component is the root of the mean variance of the three.
  ImuBiasEstimate Bias() const {
    return {state_.bias, std::sqrt(P_.block<3, 3>(kRateBias, kRateBias).trace() / 3.0),
            std::sqrt(P_.block<3, 3>(kForceBias, kForceBias).trace() / 3.0)};
  }

  bool has_begun() const { return has_begun_; }
  const InertialState& state() const { return state_; }
  const Covariance& covariance() const { return P_; }
  /// Pose since `MeasureFromHere`, T_then_now, and the covariance of its right perturbation.
  SE3 Motion() const { return T_odom_origin_.Inverse() * state_.T_odom_imu; }
  Matrix6d MotionCovariance() const;
  /// Counts motions from the present pose, as if it were exact.
  void MeasureFromHere();

  template <class Archive, class Self>
  static void Fields(Archive& a, Self& self) {
    a(self.has_begun_, self.knows_magnitude_, self.state_, self.P_, self.T_odom_origin_, self.P_since_);
  }

 private:
  using Error = Eigen::Matrix<double, kSize, 1>;

  void Correct(const Error& d);
  void UseMagnitude();
  Vector6d Residual(const SE3& T_odom_imu) const;
  Matrix6d Rotated(const Matrix6d& covariance) const;

  ImuNoise noise_;
  bool has_begun_ = false;
  bool knows_magnitude_ = false;
  InertialState state_;
  Covariance P_ = Covariance::Zero();
  /// The pose that motions are counted from, and the covariance that has grown since, without errors of that pose.
  SE3 T_odom_origin_;
  Covariance P_since_ = Covariance::Zero();
};

}  // namespace plslam
