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

/// Publishes `status_t` at 1 Hz and on each change of state. Safe from any thread.
///
/// Another process of the same name on the same bus is reported once, in the log and as the reason of the state: two
/// processes that publish the same results to the same readers are a mistake, but only the user can decide which of
/// them is intended.
class StatusPublisher {
 public:
  /// Starts in state "starting". The bus must outlive it, and must not run after its destruction.
  StatusPublisher(const std::string& process, const BusOptions& options, Bus& bus);

  /// Publishes at once if the state or the reason has changed.
  void SetState(const std::string& state, const std::string& reason = "");
  /// Sets the reason beside the state, which does not change.
  void SetReason(const std::string& reason);
  std::string state() const;
  void SetConfiguration(const std::string& yaml);
  void SetCounter(const std::string& name, double value);
  /// Returns 0 if there is none of this name.
  double counter(const std::string& name) const;

 private:
  void Publish();
  void OnStatus(const status_t& other);

  const std::chrono::steady_clock::time_point started_ = std::chrono::steady_clock::now();
  const std::string process_;
  Bus& bus_;
  std::string bus_configuration_;
  size_t max_configuration_bytes_ = 0;

  /// Other processes with our name from which one status was received, and whether one of them has been reported. On
  /// the thread of the bus.
  std::map<int64_t, std::chrono::steady_clock::time_point> namesakes_;
  bool namesake_reported_ = false;

  mutable std::mutex mutex_;  // guards the following members, and keeps states in order on the wire
  std::string state_ = process_state::kStarting;
  std::string reason_;
  std::string configuration_;
  std::map<std::string, double> counters_;
};

/// Returns a counter of a status; 0 if it has none of this name.
double CounterOf(const status_t& status, const std::string& name);
/// Returns it as an integer from 0 to 2^53; 0 for a received value that is not a number.
int64_t CountOf(const status_t& status, const std::string& name);
/// Returns the longest of its queues (counters that begin with `queue.`), at most 2^53; 0 if it has none.
double LongestQueueOf(const status_t& status);

}  // namespace plslam::bus
