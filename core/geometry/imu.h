// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>

#include <Eigen/Core>

#include "core/geometry/se3.h"

namespace plslam {

/// One sample of an inertial sensor, raw and in the sensor's frame (`imu`).
struct ImuSample {
  /// Stamp of the sensor. `ImuCalibration::time_offset_s` later on the clock of the images.
  int64_t t_ns = 0;
  Eigen::Vector3d rate_rad_s = Eigen::Vector3d::Zero();
  /// Specific force: acceleration minus gravity, +9.81 upwards at rest.
  Eigen::Vector3d force_m_s2 = Eigen::Vector3d::Zero();

  bool operator==(const ImuSample&) const = default;

  template <class Archive, class Self>
  static void Fields(Archive& a, Self& self) {
    a(self.t_ns, self.rate_rad_s, self.force_m_s2);
  }
};

/// Noise of an inertial sensor: white noise densities and random walks of the biases, for each axis. The defaults are
/// those of a consumer sensor without a data sheet, several times the white noise of a BMI055 or ICM20948: unmodelled
/// vibration and scale errors are larger than white noise.
struct ImuNoise {
  double gyroscope_rad_s_sqrt_hz = 0.001;
  double gyroscope_walk_rad_s2_sqrt_hz = 1e-4;
  double accelerometer_m_s2_sqrt_hz = 0.01;
  double accelerometer_walk_m_s3_sqrt_hz = 1e-3;

  template <class Archive, class Self>
  static void Fields(Archive& a, Self& self) {
    a(self.gyroscope_rad_s_sqrt_hz, self.gyroscope_walk_rad_s2_sqrt_hz, self.accelerometer_m_s2_sqrt_hz,
      self.accelerometer_walk_m_s3_sqrt_hz);
  }
};

/// An inertial sensor that is mounted rigidly beside the cameras.
struct ImuCalibration {
  /// Pose of the sensor in the body frame, which is also that of `CameraCalibration::T_b_cam`.
  SE3 T_b_imu;
  ImuNoise noise;
  /// Added to a stamp of the sensor it gives the time on the clock of the images.
  double time_offset_s = 0.0;
  /// Nominal rate; 0 if it is not known.
  double rate_hz = 0.0;

  int64_t offset_ns() const;
};

/// Largest accepted magnitude of `ImuCalibration::time_offset_s`.
inline constexpr double kMaxImuOffset_s = 1.0;

inline int64_t ImuCalibration::offset_ns() const {
  return static_cast<int64_t>(time_offset_s * 1e9 + (time_offset_s < 0.0 ? -0.5 : 0.5));
}

/// Returns the samples of a motion between two times of the sensor's clock, of samples in order of increasing time:
/// from the last one at or before `from_ns` to the first one at or after `to_ns`, as far as there are such.
inline std::span<const ImuSample> SamplesOfMotion(std::span<const ImuSample> samples, int64_t from_ns,
                                                  int64_t to_ns) {
  const auto is_before = [](const ImuSample& sample, int64_t t_ns) { return sample.t_ns < t_ns; };
  auto begin = std::lower_bound(samples.begin(), samples.end(), from_ns, is_before);
  if (begin != samples.begin() && (begin == samples.end() || begin->t_ns > from_ns)) --begin;
  auto end = std::lower_bound(begin, samples.end(), to_ns, is_before);
  if (end != samples.end()) ++end;
  return {begin, end};
}

}  // namespace plslam
