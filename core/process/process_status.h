// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <map>
#include <mutex>
#include <set>
#include <string>
#include <utility>

#include "core/bus/bus.h"
#include "core/process/namesake_watch.h"
#include "core/run/process_names.h"

namespace plslam {
class status_t;
}

namespace plslam::bus {

/// Publishes `status_t` at 1 Hz and on each change of state, which it repeats after a fifth of a second: a status may be
/// lost, and the end of a run depends on it. Safe from any thread.
///
/// Watches for other processes of the same name on the same bus (`NamesakeWatch`): calls `on_older` if this process has
/// to yield to one, and warns of one that should have yielded.
class StatusPublisher {
 public:
  /// Starts in state "starting". The bus must outlive it, and must not run after its destruction. `on_older` gets a
  /// sentence with the remedy; it is called once, on the thread of the bus.
  StatusPublisher(const std::string& process, const BusOptions& options, Bus& bus,
                  std::function<void(const std::string& sentence)> on_older = nullptr);

  /// Publishes the status now.
  void Publish();

  /// Publishes at once if the state or the reason has changed.
  void SetState(const std::string& state, const std::string& reason = "");
  /// Sets the reason beside the state, which does not change.
  void SetReason(const std::string& reason);
  std::string state() const;
  /// Logs a warning, publishes it as `warning_t`, and appends it to the reason of the status. Returns false, and does
  /// nothing, if it was published before, or if there were ten other sentences with this code.
  bool Warn(const std::string& code, const std::string& sentence);
  void SetConfiguration(const std::string& yaml);
  void SetCounter(const std::string& name, double value);
  /// Returns 0 if there is none of this name.
  double counter(const std::string& name) const;

 private:
  void OnTick();
  void OnStatus(const status_t& other);
  ProcessIdentity Identity() const;

  const std::chrono::steady_clock::time_point started_ = std::chrono::steady_clock::now();
  const double started_utc_s_;
  const std::string process_;
  Bus& bus_;
  std::string bus_configuration_;
  size_t max_configuration_bytes_ = 0;

  /// On the thread of the bus.
  int ticks_ = 0;
  NamesakeWatch namesakes_;
  std::function<void(const std::string& sentence)> on_older_;

  mutable std::mutex mutex_;  // guards the following members, and keeps states in order on the wire
  std::string state_ = process_state::kStarting;
  std::string reason_;
  std::string configuration_;
  std::map<std::string, double> counters_;
  std::map<std::string, std::set<std::string>> warned_;  ///< sentences by code
  std::string newest_warning_;
  bool has_changed_ = false;  ///< since the last tick
};

/// Counters of lost messages by channel begin so; the channel's name follows.
inline constexpr const char* kLostOf = "bus.lost.";

/// Returns a counter of a status; 0 if it has none of this name.
double CounterOf(const status_t& status, const std::string& name);
/// Returns it as an integer from 0 to 2^53; 0 for a received value that is not a number.
int64_t CountOf(const status_t& status, const std::string& name);
/// Returns the longest of its queues (counters that begin with `queue.`), at most 2^53; 0 if it has none.
double LongestQueueOf(const status_t& status);

}  // namespace plslam::bus
