// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/bus/bus.h"
#include "core/geometry/imu.h"
#include "core/inertial/inertial_interval.h"

namespace plslam {
class imu_interval_t;
class imu_sample_t;
class imu_t;
}  // namespace plslam

namespace plslam::bus {

/// The samples of one message on IMU; see lcmtypes/imu_t.lcm.
struct ImuBatch {
  /// Time of the previous frame and of the frame that follows.
  int64_t from_ns = 0;
  int64_t t_ns = 0;
  bool complete = true;
  std::vector<ImuSample> samples;
};

imu_sample_t ToMessage(const ImuSample& sample);
/// Appends a sample. Returns false if a value is not finite, or the sample not later than the last one.
bool AppendTo(std::vector<ImuSample>& samples, const imu_sample_t& message);

/// Without the samples.
imu_interval_t ToMessage(const InertialInterval& interval);
/// Returns nullopt for an interval that is too long, an invalid pose, and densities or sigmas that are not positive;
/// an empty interval has no other values.
std::optional<InertialInterval> FromMessage(const imu_interval_t& message);

/// Header not filled in, except for its time.
imu_t ToMessage(const ImuBatch& batch);
/// Returns nullopt for values that are not finite, and for samples whose times do not increase.
std::optional<ImuBatch> FromMessage(const imu_t& message);

/// Publishes the samples that lead to a frame, in as many messages as they need.
void PublishImu(Bus& bus, int64_t from_ns, int64_t t_ns, std::span<const ImuSample> samples);

/// The calibration of a sensor as words, every number to its last digit: in `camera_t` it follows the kind of the rig,
/// because the layout of that message is that of logs of earlier versions. Returns nullopt for anything else, and for
/// values out of bounds.
std::string ImuText(const ImuCalibration& imu);
std::optional<ImuCalibration> ImuFromText(std::string_view text);

}  // namespace plslam::bus
