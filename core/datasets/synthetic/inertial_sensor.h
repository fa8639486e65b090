// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "core/datasets/synthetic/exact_math.h"
#include "core/datasets/synthetic/motion.h"
#include "core/geometry/imu.h"

namespace plslam::synthetic {

/// Gravity of all worlds.
inline constexpr double kGravity_m_s2 = 9.81;

/// Returns a number of the standard normal distribution: a sum of twelve uniform ones.
double Normal(Random& random);

/// An inertial sensor by its data sheet: white noise, random walks, and the sigma of the biases at the start.
struct SensorClass {
  std::string name;
  ImuNoise noise;
  double rate_bias_rad_s = 0.0;
  double force_bias_m_s2 = 0.0;
  /// Without noise and biases; its `noise` is what a filter may assume.
  bool is_exact = false;
};

/// Named classes, in the order of the documentation.
const std::vector<SensorClass>& SensorClasses();

/// A motion to be sampled. `up` is the vertical of its frame.
struct SensedMotion {
  const Motion* motion = nullptr;
  double frame_rate_hz = 0.0;
  double end_s = 0.0;  ///< time of the last frame; the first one is at 0
  Eigen::Vector3d up = Eigen::Vector3d::UnitZ();
};

/// Pose of the sensor (x forward, y left, z up) in the left camera.
SE3 MountedSensor();

/// Samples from just before the first frame to just after the last one.
///
/// Rate and force are means over about one sample, from differences of the poses: their sums are the differences of
/// poses and velocities, without any error of interpolation, however rough the motion is. Biases and noise depend on
/// the seed only.
std::vector<ImuSample> SampleMotion(const SensedMotion& sensed, double rate_hz, const SensorClass& sensor,
                                    uint64_t seed);

}  // namespace plslam::synthetic
