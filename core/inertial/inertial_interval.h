// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "core/geometry/imu.h"
#include "core/geometry/se3.h"
#include "core/inertial/preintegration.h"

namespace plslam {

/// Samples of an inertial sensor between two keyframes, and its errors as the tracker knew them at the later one.
struct InertialInterval {
  /// Longest interval: the error of a position by accelerations grows with the square of the time.
  static constexpr uint64_t kLongest_ns = 3'000'000'000;

  /// Times of the keyframes on the clock of the sensor; equal: nothing is known of the interval.
  int64_t from_ns = 0;
  int64_t to_ns = 0;
  /// In order of time, as `SamplesOfMotion`.
  std::vector<ImuSample> samples;
  /// Pose of the sensor in the rectified left camera.
  SE3 T_c_imu;
  ImuNoise noise;
  ImuBiasEstimate bias;

  bool empty() const { return from_ns == to_ns; }
  /// Time until `end_ns`, which must not be before the begin; unsigned, because stamps may have any value.
  uint64_t LengthUntil(int64_t end_ns) const {
    return static_cast<uint64_t>(end_ns) - static_cast<uint64_t>(from_ns);
  }
  /// Appends what was sensed up to a later time. Samples that are not later than the last one are repetitions.
  void Append(std::span<const ImuSample> more, int64_t until_ns);

  /// Returns the motion, integrated with the mean `bias`; nullopt if it is empty, and as `Preintegrate`.
  std::optional<Preintegration> Motion() const { return Preintegrate(samples, from_ns, to_ns, noise, bias.mean); }

  template <class Archive, class Self>
  static void Fields(Archive& a, Self& self) {
    a(self.from_ns, self.to_ns, self.samples, self.T_c_imu, self.noise, self.bias);
  }
};

}  // namespace plslam
