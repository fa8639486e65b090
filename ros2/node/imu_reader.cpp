// SPDX-License-Identifier: BSD-3-Clause
#include "ros2/node/imu_reader.h"

#include <set>

#include "core/files/dataset_error.h"

namespace plslam::ros2 {

void ImuReader::ReadFrom(Participant& participant, robot::ImuInput& input) {
  if (topics_.rates.empty()) return;
  for (const std::string& topic : std::set{topics_.rates, topics_.forces}) {
    const bool has_rate = topic == topics_.rates, has_force = topic == topics_.forces;
    participant.ReadImu(topic, [this, &input, has_rate, has_force](const RosImu& message) {
      Take(message, has_rate, has_force, input);
    });
  }
}

void ImuReader::CountRejected() { process_.SetCounter("imu.rejected", static_cast<double>(++n_rejected_)); }

/// `has_rate` and `has_force` are what the topic is for.
void ImuReader::Take(const RosImu& message, bool has_rate, bool has_force, robot::ImuInput& input) {
  if ((has_rate && !message.has_rate) || (has_force && !message.has_force)) {
    throw DatasetError("has a covariance that begins with -1, and so nothing was measured");
  }
  if (has_rate && frame_.empty()) frame_ = message.frame;
  const ImuSample& sample = message.sample;
  if (has_rate && has_force) {
    input.Add(sample);
  } else if (has_rate) {
    input.AddRate(sample.t_ns, sample.rate_rad_s);
  } else {
    input.AddForce(sample.t_ns, sample.force_m_s2);
  }
}

}  // namespace plslam::ros2
