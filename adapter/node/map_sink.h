// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <mutex>
#include <optional>
#include <string>

#include "core/bus/messages/map_channel.h"
#include "core/bus/transport/stock_lcm.h"
#include "core/geometry/se3.h"
#include "core/process/process.h"

namespace plslam::adapter {

/// The points of the map to the robot, whole, when they have changed, at most once a second. On the thread of
/// `Bus::Run`.
class MapSink {
 public:
  MapSink(bus::Process& process, bus::StockLcm& foreign, const std::string& channel);

  /// From any thread.
  void SetBody(const SE3& T_b_c);

 private:
  void Tick();

  bus::Process& process_;
  bus::StockLcm& foreign_;
  const std::string channel_;
  std::mutex mutex_;  // of `T_b_c_`
  std::optional<SE3> T_b_c_;
  std::optional<int64_t> changed_t_ns_;
  int64_t n_sent_ = 0;
  bus::MapSubscriber map_;
};

}  // namespace plslam::adapter
