// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "core/geometry/imu.h"
#include "core/geometry/se3.h"

namespace plslam {

/// Slowly changing errors of a sensor: a sample is the truth plus bias plus white noise.
struct ImuBias {
  Eigen::Vector3d rate_rad_s = Eigen::Vector3d::Zero();
  Eigen::Vector3d force_m_s2 = Eigen::Vector3d::Zero();

  template <class Archive, class Self>
  static void Fields(Archive& a, Self& self) {
    a(self.rate_rad_s, self.force_m_s2);
  }
};

/// Biases as they are estimated.
struct ImuBiasEstimate {
  ImuBias mean;
  /// Sigma of each component.
  double rate_sigma_rad_s = 0.0;
  double force_sigma_m_s2 = 0.0;

  template <class Archive, class Self>
  static void Fields(Archive& a, Self& self) {
    a(self.mean, self.rate_sigma_rad_s, self.force_sigma_m_s2);
  }
};

/// The motion of an inertial sensor over an interval, integrated from its samples in its own frame at the beginning (i),
/// without gravity and initial velocity (Forster, Carlone, Dellaert, Scaramuzza, "On-Manifold Preintegration for
/// Real-Time Visual-Inertial Odometry", T-RO 2017, §V and VI). With gravity g and velocity v in a fixed frame w, over t:
///
///   R_w_j = R_w_i * dR      v_j = v_i + g t + R_w_i * dv      p_j = p_i + v_i t + g t^2 / 2 + R_w_i * dp
///
/// Samples are interpolated linearly, and each step uses the values in its middle: the error is of second order in the
/// step.
class Preintegration {
 public:
  using Matrix9d = Eigen::Matrix<double, 9, 9>;
  /// Derivatives with respect to the biases; of dR that of its right perturbation.
  struct Jacobians {
    Eigen::Matrix3d R_rate = Eigen::Matrix3d::Zero();
    Eigen::Matrix3d v_rate = Eigen::Matrix3d::Zero();
    Eigen::Matrix3d v_force = Eigen::Matrix3d::Zero();
    Eigen::Matrix3d p_rate = Eigen::Matrix3d::Zero();
    Eigen::Matrix3d p_force = Eigen::Matrix3d::Zero();
  };

  /// An empty interval.
  Preintegration(const ImuNoise& noise, const ImuBias& bias) : noise_(noise), bias_(bias) {}

  /// Appends a step of mean angular rate and specific force, as measured. `dt_s` > 0.
  void Append(const Eigen::Vector3d& rate_rad_s, const Eigen::Vector3d& force_m_s2, double dt_s);

  double dt_s() const { return dt_s_; }
  const Eigen::Quaterniond& dR() const { return dR_; }
  const Eigen::Vector3d& dv_m_s() const { return dv_m_s_; }
  const Eigen::Vector3d& dp_m() const { return dp_m_; }
  const Jacobians& jacobians() const { return jacobians_; }
  const ImuBias& bias() const { return bias_; }
  /// Covariance by white noise of [rotation; dv; dp]; of dR that of its right perturbation.
  const Matrix9d& covariance() const { return covariance_; }

  /// Returns dR, dv and dp for another bias, to first order.
  Eigen::Quaterniond RotationWith(const ImuBias& bias) const;
  Eigen::Vector3d VelocityWith(const ImuBias& bias) const;
  Eigen::Vector3d PositionWith(const ImuBias& bias) const;

 private:
  ImuNoise noise_;
  ImuBias bias_;
  double dt_s_ = 0.0;
  Eigen::Quaterniond dR_ = Eigen::Quaterniond::Identity();
  Eigen::Vector3d dv_m_s_ = Eigen::Vector3d::Zero();
  Eigen::Vector3d dp_m_ = Eigen::Vector3d::Zero();
  Jacobians jacobians_;
  Matrix9d covariance_ = Matrix9d::Zero();
};

/// Integrates samples, whose times increase, from one time to another (all on the sensor's clock), interpolated at both
/// ends. Returns nullopt if the samples do not reach the ends (up to 20 ms, over which the outermost sample holds), have
/// a gap of more than 0.15 s in between, or if `to_ns` is not later than `from_ns`. Missing samples add to the noise.
std::optional<Preintegration> Preintegrate(std::span<const ImuSample> samples, int64_t from_ns, int64_t to_ns,
                                           const ImuNoise& noise, const ImuBias& bias);

/// Right Jacobian of SO(3): Exp(w + d) = Exp(w) Exp(Jr(w) d) to first order.
Eigen::Matrix3d RightJacobianSO3(const Eigen::Vector3d& w);

}  // namespace plslam
