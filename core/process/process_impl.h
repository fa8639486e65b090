#pragma once

#include <atomic>

#include "core/process/process.h"
#include "core/process/process_status.h"

namespace plslam::bus {

struct Process::Impl {
  Impl(const std::string& name, const BusOptions& options, Bus& bus) : status(name, options, bus) {}

  StatusPublisher status;
  std::atomic<int> exit_code{0};
  std::atomic<bool> finished{false};
};

}  // namespace plslam::bus
