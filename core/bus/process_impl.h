#pragma once

#include <atomic>
#include <chrono>
#include <functional>
#include <map>
#include <mutex>
#include <string>

#include "core/bus/process.h"

namespace plslam::bus {

/// State of a Process that the status tells.
struct Process::Impl {
  void PublishStatus(const std::string& name, Bus& bus);

  const std::chrono::steady_clock::time_point started = std::chrono::steady_clock::now();
  std::function<void()> publish;
  std::string bus_configuration;
  size_t max_configuration_bytes = 0;

  std::mutex mutex;  ///< guards what follows, up to the exit code
  std::string state = "starting";
  std::string reason;
  std::string configuration;
  std::map<std::string, double> counters;

  std::atomic<int> exit_code{0};
  std::atomic<bool> finished{false};
};

}  // namespace plslam::bus
