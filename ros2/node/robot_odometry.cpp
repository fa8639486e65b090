// SPDX-License-Identifier: BSD-3-Clause
#include "ros2/node/robot_odometry.h"

#include <fmt/format.h>

#include <utility>

#include "core/bus/channels.h"
#include "core/bus/messages/convert.h"
#include "core/errors/error_text.h"
#include "plslam/robot_motion_t.hpp"

namespace plslam::ros2 {
namespace {

/// Wheels may start later than cameras.
constexpr int64_t kFramesWithoutMotions = 20;

}  // namespace

void RobotOdometry::ReadFrom(Participant& participant) {
  if (topic_.empty()) return;
  participant.ReadOdometry(topic_, [this](int64_t t_ns, const SE3& T_robot_b) { Send(t_ns, T_robot_b); });
}

void RobotOdometry::CountRejected() { process_.SetCounter("motions.rejected", static_cast<double>(++n_rejected_)); }

void RobotOdometry::Send(int64_t t_ns, const SE3& T_robot_b) {
  robot_motion_t motion{};
  motion.header.t_ns = t_ns;
  motion.T_robot_b = bus::ToMessage(T_robot_b);
  process_.bus().Publish(bus::kRobotMotion, motion);
  ++n_sent_;
}

void RobotOdometry::Report(int64_t n_frames) {
  if (topic_.empty()) return;
  process_.SetCounter("motions.sent", static_cast<double>(n_sent_));
  if (n_sent_ > 0 || n_frames < kFramesWithoutMotions || std::exchange(has_warned_, true)) return;
  const bool is_silent = n_rejected_ == 0;
  process_.Warn("robot_odometry_missing",
                fmt::format("no message {} {} (ros2.robot_odometry), so frames are tracked without the robot's "
                            "odometry: {}",
                            is_silent ? "arrives on" : "can be used of", Shown(topic_),
                            is_silent ? "`plslam topics ros2:` lists the topics of nav_msgs/msg/Odometry"
                                      : "the log has the reason"));
}

}  // namespace plslam::ros2
