// SPDX-License-Identifier: BSD-3-Clause
#include "adapter/node/motion_source.h"

#include <fmt/format.h>

#include <chrono>

#include "adapter/node/foreign_messages.h"
#include "core/bus/messages/convert.h"
#include "core/bus/run_loop.h"
#include "core/errors/error_text.h"
#include "core/io/files/dataset_error.h"
#include "plslam/robot_motion_t.hpp"

namespace plslam::adapter {
namespace {

/// Messages that wait: half a second of fast wheels.
constexpr size_t kMotionsRoom = 100;
constexpr std::chrono::milliseconds kMotionsTick{1000};

}  // namespace

MotionSource::MotionSource(bus::Process& process, bus::StockLcm& foreign, const std::string& channel)
    : process_(process), channel_(channel), inbox_(kMotionsRoom) {
  foreign.Subscribe(channel, [this](MessageBytes bytes) { inbox_.Put(0, bytes); });
  thread_ = std::thread([this] { bus::RunGuarded(process_.bus(), [this] { Work(); }); });
}

MotionSource::~MotionSource() {
  inbox_.Stop();
  thread_.join();
}

void MotionSource::Work() {
  while (!inbox_.stopped()) {
    if (const auto message = inbox_.Take(kMotionsTick)) Send(*message);
  }
}

void MotionSource::Send(const Inbox::Message& message) {
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
