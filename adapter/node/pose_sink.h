// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <deque>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include "adapter/options.h"
#include "core/bus/transport/stock_lcm.h"
#include "core/process/process.h"
#include "core/robot/body_pose.h"
#include "core/robot/node/inbox.h"
#include "core/robot/node/pose_steps.h"
#include "core/ros/body_messages.h"

namespace plslam {
class pose_t;
}

namespace plslam::adapter {

/// Passes poses of the bus to the robot: each frame's once, on arrival, on a separate thread that is not delayed by
/// images or the map. Only poses of frames that this process has sent are passed: republished history is ignored.
class PoseSink {
 public:
  PoseSink(bus::Process& process, bus::StockLcm& foreign, const AdapterOptions& options);
  ~PoseSink();
  PoseSink(const PoseSink&) = delete;
  PoseSink& operator=(const PoseSink&) = delete;

  // From any thread.
  void SetBody(const SE3& T_b_c);
  void OnFrame(int64_t t_ns);

 private:
  void Work();
  void Send(const pose_t& message);
  std::optional<SE3> BodyOf(const pose_t& message);
  template <class Message>
  void Publish(const std::string& channel, const Message& message);

  bus::Process& process_;
  bus::StockLcm& foreign_;
  const AdapterOptions options_;
  const RobotFrames names_;

  /// The receiving thread of the bus, which puts poses there, may outlive us.
  const std::shared_ptr<robot::Inbox> inbox_;
  std::mutex mutex_;  // guards what follows
  std::optional<SE3> T_b_c_;
  std::deque<int64_t> frames_;

  // Of the thread.
  robot::PoseSteps steps_;
  int64_t n_sent_ = 0, n_failed_ = 0;
  std::thread thread_;
};

}  // namespace plslam::adapter
