// SPDX-License-Identifier: BSD-3-Clause
#include "core/inertial/preintegration.h"

#include <algorithm>
#include <cmath>

#include "core/geometry/hypot.h"

namespace plslam {
namespace {

// Longest interval between samples that is interpolated.
constexpr double kLongestGap_s = 0.15;
// Longest interval over which the outermost sample holds.
constexpr double kLongestHold_s = 0.02;
// Longest interval between samples that linear interpolation describes: that of a sensor of 100 Hz, with its jitter.
constexpr double kDense_s = 0.015;
// Share of the change over an interval that the mean of the interval is off by, if the value at one end holds, and if
// those at both ends are interpolated.
constexpr double kHeld = 0.5;
constexpr double kInterpolated = 0.25;

/// Unsigned: stamps may have any value. `later_ns` must not be earlier.
double SecondsBetween(int64_t earlier_ns, int64_t later_ns) {
  return 1e-9 * static_cast<double>(static_cast<uint64_t>(later_ns) - static_cast<uint64_t>(earlier_ns));
}

/// Mean squares of the changes of rate and force a second between samples, without what their noise contributes; each
/// axis.
struct Changes {
  double rate2 = 0.0;
  double force2 = 0.0;
};

Changes ChangesOf(std::span<const ImuSample> samples, const ImuNoise& noise) {
  Vector6d sum2 = Vector6d::Zero();
  double inverse_s = 0.0, squares_s2 = 0.0;
  for (size_t i = 1; i < samples.size(); ++i) {
    if (samples[i].t_ns <= samples[i - 1].t_ns) continue;
    const double dt_s = SecondsBetween(samples[i - 1].t_ns, samples[i].t_ns);
    Vector6d change;
    change << samples[i].rate_rad_s - samples[i - 1].rate_rad_s, samples[i].force_m_s2 - samples[i - 1].force_m_s2;
    sum2 += change.cwiseAbs2();
    inverse_s += 1.0 / dt_s;
    squares_s2 += dt_s * dt_s;
  }
  if (squares_s2 == 0.0) return {};
  // A sample is a mean over its interval: its variance is the square of the density over that.
  const auto mean2 = [&](int first, double density) {
    const double noise2 = 2.0 * density * density * inverse_s;
    return std::max(0.0, sum2.segment<3>(first).sum() / 3.0 - noise2) / squares_s2;
  };
  return {mean2(0, noise.gyroscope_rad_s_sqrt_hz), mean2(3, noise.accelerometer_m_s2_sqrt_hz)};
}

/// Sum of the squares by which integrals over the steps of a motion are off for each square of a change a second, s^4.
double Unsensed(std::span<const ImuSample> samples, int64_t from_ns, int64_t to_ns) {
  double unsensed_s4 = 0.0;
  const auto add = [&](double share, double apart_s, double step_s) {
    unsensed_s4 += share * share * apart_s * apart_s * step_s * step_s;
  };
  const int64_t first_ns = samples.front().t_ns, last_ns = samples.back().t_ns;
  if (first_ns > from_ns) add(kHeld, SecondsBetween(from_ns, first_ns), SecondsBetween(from_ns, first_ns));
  if (last_ns < to_ns) add(kHeld, SecondsBetween(last_ns, to_ns), SecondsBetween(last_ns, to_ns));
  for (size_t i = 1; i < samples.size(); ++i) {
    const int64_t a_ns = samples[i - 1].t_ns, b_ns = samples[i].t_ns;
    const int64_t begin_ns = std::max(a_ns, from_ns), end_ns = std::min(b_ns, to_ns);
    if (begin_ns >= end_ns) continue;
    const double apart_s = SecondsBetween(a_ns, b_ns);
    if (apart_s > kDense_s) add(kInterpolated, apart_s, SecondsBetween(begin_ns, end_ns));
  }
  return unsensed_s4;
}

/// The noise of a motion in which samples are missing: rates and forces have changed there as fast as between the others.
/// The variance of that counts as white noise over the whole motion.
ImuNoise NoiseOfMotion(std::span<const ImuSample> samples, int64_t from_ns, int64_t to_ns, const ImuNoise& noise) {
  const double unsensed_s4 = Unsensed(samples, from_ns, to_ns);
  if (unsensed_s4 == 0.0) return noise;
  const Changes changes = ChangesOf(samples, noise);
  const double unsensed_s3 = unsensed_s4 / SecondsBetween(from_ns, to_ns);
  ImuNoise with = noise;
  with.gyroscope_rad_s_sqrt_hz = Hypot(noise.gyroscope_rad_s_sqrt_hz, std::sqrt(changes.rate2 * unsensed_s3));
  with.accelerometer_m_s2_sqrt_hz = Hypot(noise.accelerometer_m_s2_sqrt_hz, std::sqrt(changes.force2 * unsensed_s3));
  return with;
}

ImuSample Between(const ImuSample& a, const ImuSample& b, int64_t t_ns) {
  if (t_ns <= a.t_ns) return {t_ns, a.rate_rad_s, a.force_m_s2};
  if (t_ns >= b.t_ns) return {t_ns, b.rate_rad_s, b.force_m_s2};
  const double share = SecondsBetween(a.t_ns, t_ns) / SecondsBetween(a.t_ns, b.t_ns);
  return {t_ns, a.rate_rad_s + share * (b.rate_rad_s - a.rate_rad_s),
          a.force_m_s2 + share * (b.force_m_s2 - a.force_m_s2)};
}

}  // namespace

Eigen::Matrix3d RightJacobianSO3(const Eigen::Vector3d& w) {
  const double angle2 = w.squaredNorm();
  const Eigen::Matrix3d W = Skew(w);
  if (angle2 < 1e-8) return Eigen::Matrix3d::Identity() - 0.5 * W + W * W / 6.0;
  const double angle = std::sqrt(angle2);
  return Eigen::Matrix3d::Identity() - (1.0 - std::cos(angle)) / angle2 * W +
         (angle - std::sin(angle)) / (angle2 * angle) * W * W;
}

void Preintegration::Append(const Eigen::Vector3d& rate_rad_s, const Eigen::Vector3d& force_m_s2, double dt_s) {
  const Eigen::Vector3d turn = (rate_rad_s - bias_.rate_rad_s) * dt_s;
  const Eigen::Vector3d force = force_m_s2 - bias_.force_m_s2;
  const Eigen::Quaterniond step = ExpSO3(turn);
  const Eigen::Quaterniond half = ExpSO3(0.5 * turn);
  const Eigen::Matrix3d step_t = step.toRotationMatrix().transpose();
  const Eigen::Matrix3d half_t = half.toRotationMatrix().transpose();
  const Eigen::Matrix3d Jr = RightJacobianSO3(turn);
  const Eigen::Matrix3d R_middle = (dR_ * half).toRotationMatrix();
  const Eigen::Matrix3d R_force = R_middle * Skew(force);
  const double dt2 = dt_s * dt_s;

  Matrix9d A = Matrix9d::Identity();
  A.block<3, 3>(0, 0) = step_t;
  A.block<3, 3>(3, 0) = -dt_s * R_force * half_t;
  A.block<3, 3>(6, 0) = -0.5 * dt2 * R_force * half_t;
  A.block<3, 3>(6, 3) = dt_s * Eigen::Matrix3d::Identity();
  Eigen::Matrix<double, 9, 6> B = Eigen::Matrix<double, 9, 6>::Zero();
  B.block<3, 3>(0, 0) = dt_s * Jr;
  B.block<3, 3>(3, 3) = dt_s * R_middle;
  B.block<3, 3>(6, 3) = 0.5 * dt2 * R_middle;
  Vector6d variances;
  variances << Eigen::Vector3d::Constant(noise_.gyroscope_rad_s_sqrt_hz * noise_.gyroscope_rad_s_sqrt_hz / dt_s),
      Eigen::Vector3d::Constant(noise_.accelerometer_m_s2_sqrt_hz * noise_.accelerometer_m_s2_sqrt_hz / dt_s);
  covariance_ = A * covariance_ * A.transpose() + B * variances.asDiagonal() * B.transpose();

  Jacobians& J = jacobians_;
  const Eigen::Matrix3d J_middle = half_t * J.R_rate - 0.5 * dt_s * RightJacobianSO3(0.5 * turn);
  J.p_rate += dt_s * J.v_rate - 0.5 * dt2 * R_force * J_middle;
  J.p_force += dt_s * J.v_force - 0.5 * dt2 * R_middle;
  J.v_rate -= dt_s * R_force * J_middle;
  J.v_force -= dt_s * R_middle;
  J.R_rate = step_t * J.R_rate - dt_s * Jr;

  dp_m_ += dt_s * dv_m_s_ + 0.5 * dt2 * (R_middle * force);
  dv_m_s_ += dt_s * (R_middle * force);
  dR_ = (dR_ * step).normalized();
  dt_s_ += dt_s;
}

Eigen::Quaterniond Preintegration::RotationWith(const ImuBias& bias) const {
  return dR_ * ExpSO3(jacobians_.R_rate * (bias.rate_rad_s - bias_.rate_rad_s));
}

Eigen::Vector3d Preintegration::VelocityWith(const ImuBias& bias) const {
  return dv_m_s_ + jacobians_.v_rate * (bias.rate_rad_s - bias_.rate_rad_s) +
         jacobians_.v_force * (bias.force_m_s2 - bias_.force_m_s2);
}

Eigen::Vector3d Preintegration::PositionWith(const ImuBias& bias) const {
  return dp_m_ + jacobians_.p_rate * (bias.rate_rad_s - bias_.rate_rad_s) +
         jacobians_.p_force * (bias.force_m_s2 - bias_.force_m_s2);
}

std::optional<Preintegration> Preintegrate(std::span<const ImuSample> samples, int64_t from_ns, int64_t to_ns,
                                           const ImuNoise& noise, const ImuBias& bias) {
  if (from_ns >= to_ns || samples.empty()) return std::nullopt;
  const ImuSample &first = samples.front(), &last = samples.back();
  if (first.t_ns > from_ns && SecondsBetween(from_ns, first.t_ns) > kLongestHold_s) return std::nullopt;
  if (last.t_ns < to_ns && SecondsBetween(last.t_ns, to_ns) > kLongestHold_s) return std::nullopt;
  if (last.t_ns <= from_ns || first.t_ns >= to_ns) return std::nullopt;
  Preintegration motion(NoiseOfMotion(SamplesOfMotion(samples, from_ns, to_ns), from_ns, to_ns, noise), bias);
  const auto append = [&motion](const ImuSample& a, const ImuSample& b) {
    if (b.t_ns <= a.t_ns) return;
    motion.Append(0.5 * (a.rate_rad_s + b.rate_rad_s), 0.5 * (a.force_m_s2 + b.force_m_s2),
                  SecondsBetween(a.t_ns, b.t_ns));
  };
  if (first.t_ns > from_ns) append({from_ns, first.rate_rad_s, first.force_m_s2}, first);
  for (size_t i = 1; i < samples.size(); ++i) {
    const ImuSample &a = samples[i - 1], &b = samples[i];
    const int64_t begin_ns = std::max(a.t_ns, from_ns), end_ns = std::min(b.t_ns, to_ns);
    if (begin_ns >= end_ns) continue;
    if (SecondsBetween(a.t_ns, b.t_ns) > kLongestGap_s) return std::nullopt;
    append(Between(a, b, begin_ns), Between(a, b, end_ns));
  }
  if (last.t_ns < to_ns) append(last, {to_ns, last.rate_rad_s, last.force_m_s2});
  return motion;
}

}  // namespace plslam
