// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <thread>

#include "adapter/node/inbox.h"
#include "adapter/node/skipped_messages.h"
#include "core/bus/transport/stock_lcm.h"
#include "core/process/process.h"

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
  void Send(const Inbox::Message& message);

  bus::Process& process_;
  const std::string channel_;
  const std::function<int64_t()> n_frames_;
  Inbox inbox_;
  // Of the thread.
  SkippedMessages skipped_messages_;
  int64_t n_sent_ = 0, n_rejected_ = 0;
  bool is_reported_ = false;
  std::thread thread_;
};

}  // namespace plslam::adapter
