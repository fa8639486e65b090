// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>

#include "core/datasets/imu_topics.h"
#include "core/datasets/recordings/ros_messages.h"
#include "core/process/process.h"
#include "core/robot/node/imu_input.h"
#include "ros2/dds/participant.h"

namespace plslam::ros2 {

/// The topics of the inertial sensor, if there is one: of complete samples, or one of rates and one of forces. Messages
/// that cannot be used are counted (`imu.rejected`).
class ImuReader {
 public:
  /// `topic`: one of its topics; empty: there is no sensor.
  ImuReader(bus::Process& process, const std::string& topic)
      : process_(process), topics_(topic.empty() ? ImuTopics{} : ImuTopicsOf(topic)) {}

  /// Adds its samples to `input`.
  void ReadFrom(Participant& participant, robot::ImuInput& input);
  bool Reads(const std::string& topic) const {
    return !topics_.rates.empty() && (topic == topics_.rates || topic == topics_.forces);
  }
  void CountRejected();

  /// The frame of the sensor; empty before its first message.
  const std::string& frame() const { return frame_; }

 private:
  void Take(const RosImu& message, bool has_rate, bool has_force, robot::ImuInput& input);

  bus::Process& process_;
  const ImuTopics topics_;
  std::string frame_;
  int64_t n_rejected_ = 0;
};

}  // namespace plslam::ros2
