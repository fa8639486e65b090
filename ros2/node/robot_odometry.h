// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>

#include "core/geometry/se3.h"
#include "core/process/process.h"
#include "ros2/dds/participant.h"

namespace plslam::ros2 {

/// The robot's own odometry, if it has a topic: its poses go to the tracker as they arrive. They are counted
/// (`motions.sent`, `motions.rejected`), and the warning `robot_odometry_missing` reports a silent topic.
class RobotOdometry {
 public:
  /// `topic` of nav_msgs/msg/Odometry; empty: there is none.
  RobotOdometry(bus::Process& process, const std::string& topic) : process_(process), topic_(topic) {}

  void ReadFrom(Participant& participant);
  bool Reads(const std::string& topic) const { return !topic_.empty() && topic == topic_; }
  void CountRejected();
  /// To be called once a second. `n_frames`: sent since the start.
  void Report(int64_t n_frames);

 private:
  void Send(int64_t t_ns, const SE3& T_robot_b);

  bus::Process& process_;
  const std::string topic_;
  int64_t n_sent_ = 0;
  int64_t n_rejected_ = 0;
  bool has_warned_ = false;
};

}  // namespace plslam::ros2
