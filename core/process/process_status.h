// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>
#include <cstdint>
#include <map>
#include <mutex>
#include <string>

#include "core/bus/bus.h"
#include "core/run/process_names.h"

namespace plslam {
class status_t;
}

namespace plslam::bus {

/// The face of a process to the world: publishes `status_t` at 1 Hz and on each change of state. Safe from any
/// thread.
///
/// Another process of the same name on the same bus is told, once, in the log and as the reason of the state: two
/// that do the same work for the same readers are a mistake, but which of them is meant only their owner knows.
class StatusPublisher {
 public:
  /// Starts in state "starting". The bus outlives it, and is not run any more once it is gone.
  StatusPublisher(const std::string& process, const BusOptions& options, Bus& bus);

  /// Publishes at once where this is news.
  void SetState(const std::string& state, const std::string& reason = "");
  /// The same of what there is to say beside the state, which stays.
  void SetReason(const std::string& reason);
  std::string state() const;
  void SetConfiguration(const std::string& yaml);
  void SetCounter(const std::string& name, double value);
  /// 0 where there is none of this name.
  double counter(const std::string& name) const;

 private:
  void Publish();
  void OnStatus(const status_t& other);

  const std::chrono::steady_clock::time_point started_ = std::chrono::steady_clock::now();
  const std::string process_;
  Bus& bus_;
  std::string bus_configuration_;
  size_t max_configuration_bytes_ = 0;

  /// Others of our name that were heard once, and whether one has been told of. On the thread of the bus.
  std::map<int64_t, std::chrono::steady_clock::time_point> namesakes_;
  bool told_of_namesake_ = false;

  mutable std::mutex mutex_;  // guards what follows, and keeps states in order on the wire
  std::string state_ = process_state::kStarting;
  std::string reason_;
  std::string configuration_;
  std::map<std::string, double> counters_;
};

/// A counter of a status; 0 where it has none of this name.
double CounterOf(const status_t& status, const std::string& name);
/// The same of a counter that counts; 0, or 2^53 at most, where what came over the bus is no such number.
int64_t CountOf(const status_t& status, const std::string& name);
/// The longest of its queues (counters that begin with `queue.`), 2^53 at most; 0 where it has none.
double LongestQueueOf(const status_t& status);

}  // namespace plslam::bus
