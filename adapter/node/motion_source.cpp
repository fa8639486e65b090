// SPDX-License-Identifier: BSD-3-Clause
#include "adapter/node/motion_source.h"

#include <fmt/format.h>

#include <chrono>
#include <utility>

#include "adapter/node/foreign_messages.h"
#include "core/bus/messages/convert.h"
#include "core/bus/run_loop.h"
#include "core/errors/error_text.h"
#include "core/files/dataset_error.h"
#include "plslam/robot_motion_t.hpp"

namespace plslam::adapter {
namespace {

/// Messages that wait: half a second of fast wheels.
constexpr size_t kMotionsRoom = 100;
constexpr std::chrono::milliseconds kMotionsTick{1000};
/// Wheels may start later than cameras.
constexpr int64_t kFramesWithoutMotions = 20;

}  // namespace

MotionSource::MotionSource(bus::Process& process, bus::StockLcm& foreign, const std::string& channel,
                           std::function<int64_t()> n_frames)
    : process_(process), channel_(channel), n_frames_(std::move(n_frames)), inbox_(kMotionsRoom) {
  foreign.Subscribe(channel, [this](MessageBytes bytes) { inbox_.Put(0, bytes); });
  thread_ = std::thread([this] { bus::RunGuarded(process_.bus(), [this] { Work(); }); });
}

MotionSource::~MotionSource() {
  inbox_.Stop();
  thread_.join();
}

void MotionSource::Work() {
  while (!inbox_.stopped()) {
    if (const auto message = inbox_.Take(kMotionsTick)) {
      Send(*message);
    } else if (n_sent_ + n_rejected_ == 0 && n_frames_() >= kFramesWithoutMotions &&
               !std::exchange(is_reported_, true)) {
      process_.Warn(
          "robot_odometry_missing",
          fmt::format("no message arrives on {} (adapter.robot_odometry), so frames are tracked without the "
                      "robot's odometry: is the channel's name right?",
                      Shown(channel_)));
    }
  }
}

void MotionSource::Send(const robot::Inbox::Message& message) {
  try {
    const RobotPose pose = RobotPoseFromBytes(message.bytes);
    robot_motion_t motion{};
    motion.header.t_ns = pose.t_ns;
    motion.T_robot_b = bus::ToMessage(pose.T_robot_b);
    process_.bus().Publish(bus::kRobotMotion, motion);
    process_.SetCounter("motions.sent", static_cast<double>(++n_sent_));
  } catch (const DatasetError& error) {
    process_.SetCounter("motions.rejected", static_cast<double>(++n_rejected_));
    skipped_messages_.WarnOnce(fmt::format("a message on {} {}", Shown(channel_), error.what()));
  }
}

}  // namespace plslam::adapter
