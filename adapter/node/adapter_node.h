// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <atomic>
#include <memory>
#include <thread>

#include "adapter/node/image_source.h"
#include "adapter/node/map_sink.h"
#include "adapter/node/motion_source.h"
#include "adapter/node/pose_sink.h"
#include "adapter/options.h"
#include "core/bus/transport/stock_lcm.h"
#include "core/process/process.h"

namespace plslam::adapter {

/// Connects a robot that uses LCM to the bus: its images (`ImageSource`) and wheel odometry (`MotionSource`) in, poses
/// (`PoseSink`) and the map (`MapSink`) out. It can restore its state from the robot and the bus, so it may be killed
/// and restarted in the middle of a session.
class AdapterNode {
 public:
  /// Throws if the robot's bus cannot be opened or the rig file cannot be used.
  AdapterNode(bus::Process& process, const AdapterOptions& options);
  ~AdapterNode();
  AdapterNode(const AdapterNode&) = delete;
  AdapterNode& operator=(const AdapterNode&) = delete;

 private:
  void Listen();
  void SetBody(const SE3& T_b_c);

  bus::Process& process_;
  /// Each of one thread; and a large map takes longer to send than a pose may wait.
  bus::StockLcm images_lcm_;
  bus::StockLcm poses_lcm_;
  bus::StockLcm maps_lcm_;
  PoseSink poses_;
  std::unique_ptr<MapSink> map_;
  ImageSource images_;
  std::unique_ptr<MotionSource> motions_;
  std::atomic<bool> stopped_ = false;
  std::thread listener_;
  std::thread worker_;
};

}  // namespace plslam::adapter
