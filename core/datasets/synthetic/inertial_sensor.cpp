// SPDX-License-Identifier: BSD-3-Clause
#include "core/datasets/synthetic/inertial_sensor.h"

#include <cmath>

#include "core/datasets/synthetic/exact_math.h"

namespace plslam::synthetic {
namespace {

// Samples and frames have different phases in practice: a share of the period of the samples.
constexpr double kPhase = 0.3;

Eigen::Vector3d NormalVector(Random& random, double sigma) {
  Eigen::Vector3d v;
  for (int i = 0; i < 3; ++i) v[i] = sigma * Normal(random);
  return v;
}

/// The rotation vector of a small rotation, by the series of the arc sine.
Eigen::Vector3d SmallRotation(const Eigen::Quaterniond& q) {
  const Eigen::Vector3d v = q.w() < 0.0 ? Eigen::Vector3d(-q.vec()) : q.vec();
  const double s = v.squaredNorm();
  return 2.0 * (1.0 + s * (1.0 / 6.0 + s * (3.0 / 40.0 + s * (15.0 / 336.0)))) * v;
}

}  // namespace

double Normal(Random& random) {
  double sum = -6.0;
  for (int i = 0; i < 12; ++i) sum += random.Uniform();
  return sum;
}

const std::vector<SensorClass>& SensorClasses() {
  static const std::vector<SensorClass> kClasses = {
      {"adis16448", {1.7e-4, 1.9e-5, 2.0e-3, 1.0e-3}, 0.03, 0.10, false},
      {"bmi055", {2.4e-4, 2.2e-5, 1.5e-3, 9.0e-4}, 0.02, 0.20, false},
      {"icm20948", {2.6e-4, 3.0e-5, 2.3e-3, 9.0e-4}, 0.04, 0.20, false},
      {"exact", {1e-5, 1e-6, 1e-4, 1e-5}, 0.0, 0.0, true},
  };
  return kClasses;
}

SE3 MountedSensor() {
  Eigen::Matrix3d R_c_imu;
  R_c_imu << 0, -1, 0, 0, 0, -1, 1, 0, 0;
  return {R_c_imu, Eigen::Vector3d(0.04, 0.02, -0.06)};
}

std::vector<ImuSample> SampleMotion(const SensedMotion& sensed, double rate_hz, const SensorClass& sensor,
                                    uint64_t seed) {
  const SE3 T_c_imu = MountedSensor();
  const double step_s = 1.0 / rate_hz;
  const auto pose_at = [&](double t_s) { return sensed.motion->At(t_s * sensed.frame_rate_hz) * T_c_imu; };
  Random random(Hash(seed, 0x696d75ULL));
  Eigen::Vector3d rate_bias = NormalVector(random, sensor.rate_bias_rad_s);
  Eigen::Vector3d force_bias = NormalVector(random, sensor.force_bias_m_s2);
  const double root_s = std::sqrt(step_s), root_hz = std::sqrt(rate_hz);
  const ImuNoise& noise = sensor.noise;
  std::vector<ImuSample> samples;
  const auto n = static_cast<int64_t>(std::ceil(sensed.end_s * rate_hz)) + 2;
  for (int64_t i = -1; i < n; ++i) {
    const double t_s = (static_cast<double>(i) + kPhase) * step_s;
    const SE3 before = pose_at(t_s - step_s), now = pose_at(t_s), after = pose_at(t_s + step_s);
    const SE3 half_before = pose_at(t_s - 0.5 * step_s), half_after = pose_at(t_s + 0.5 * step_s);
    const Eigen::Vector3d acceleration =
        (after.translation() - 2.0 * now.translation() + before.translation()) * (rate_hz * rate_hz);
    ImuSample sample{static_cast<int64_t>(std::floor(t_s * 1e9 + 0.5)),
                     rate_hz * SmallRotation(half_before.rotation().conjugate() * half_after.rotation()),
                     now.rotation().conjugate() * (acceleration + kGravity_m_s2 * sensed.up)};
    if (!sensor.is_exact) {
      sample.rate_rad_s += rate_bias + NormalVector(random, noise.gyroscope_rad_s_sqrt_hz * root_hz);
      sample.force_m_s2 += force_bias + NormalVector(random, noise.accelerometer_m_s2_sqrt_hz * root_hz);
      rate_bias += NormalVector(random, noise.gyroscope_walk_rad_s2_sqrt_hz * root_s);
      force_bias += NormalVector(random, noise.accelerometer_walk_m_s3_sqrt_hz * root_s);
    }
    samples.push_back(sample);
  }
  return samples;
}

}  // namespace plslam::synthetic
