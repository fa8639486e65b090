// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <atomic>
#include <cstdint>
#include <string>

#include "core/process/process.h"

namespace plslam::loop {

/// Counters of loops, relocalisations and failures in the status of the process. Safe from any thread.
class LoopReport {
 public:
  explicit LoopReport(bus::Process& process) : process_(process) {}

  void CountLoop();
  /// Counts a relocalisation request that was answered.
  void CountAnswer(bool found);
  /// Logs the first one.
  void CountFailedAdjustment(const std::string& failure);

 private:
  bus::Process& process_;
  std::atomic<int64_t> n_loops_{0};
  std::atomic<int64_t> n_answers_{0};
  std::atomic<int64_t> n_found_{0};
  std::atomic<int64_t> n_failed_{0};
};

}  // namespace plslam::loop
