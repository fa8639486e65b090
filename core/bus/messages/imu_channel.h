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

namespace plslam {
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
