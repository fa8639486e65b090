#pragma once

#include <chrono>
#include <map>
#include <mutex>
#include <string>

#include "core/bus/bus.h"

namespace plslam::bus {

/// The face of a process to the world: publishes `status_t` at 1 Hz and on each change of state. Safe from any thread.
class StatusPublisher {
 public:
  /// Starts in state "starting". The bus outlives it, and is not run any more once it is gone.
  StatusPublisher(const std::string& process, const BusOptions& options, Bus& bus);

  /// Publishes at once where this is news.
  void SetState(const std::string& state, const std::string& reason = "");
  std::string state() const;
  void SetConfiguration(const std::string& yaml);
  void SetCounter(const std::string& name, double value);

 private:
  void Publish();

  const std::chrono::steady_clock::time_point started_ = std::chrono::steady_clock::now();
  const std::string process_;
  Bus& bus_;
  std::string bus_configuration_;
  size_t max_configuration_bytes_ = 0;

  mutable std::mutex mutex_;  // guards what follows, and keeps states in order on the wire
  std::string state_ = "starting";
  std::string reason_;
  std::string configuration_;
  std::map<std::string, double> counters_;
};

}  // namespace plslam::bus
