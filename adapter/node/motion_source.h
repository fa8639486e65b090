// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <thread>

#include "core/bus/transport/stock_lcm.h"
#include "core/process/process.h"
#include "core/robot/node/inbox.h"
#include "core/robot/node/skipped_messages.h"

namespace plslam::adapter {

/// Passes the robot's own odometry (`nav_msgs.Odometry` of wheels) to the bus, message by message, on a separate
/// thread: a slow reader delays no image.
class MotionSource {
 public:
  /// `n_frames`: number of frames sent so far; from any thread.
  MotionSource(bus::Process& process, bus::StockLcm& foreign, const std::string& channel,
               std::function<int64_t()> n_frames);
  ~MotionSource();
  MotionSource(const MotionSource&) = delete;
  MotionSource& operator=(const MotionSource&) = delete;

 private:
  void Work();
  void Send(const robot::Inbox::Message& message);

  bus::Process& process_;
  const std::string channel_;
  const std::function<int64_t()> n_frames_;
  robot::Inbox inbox_;
  // Of the thread.
  robot::SkippedMessages skipped_messages_;
  int64_t n_sent_ = 0, n_rejected_ = 0;
  bool is_reported_ = false;
  std::thread thread_;
};

}  // namespace plslam::adapter
