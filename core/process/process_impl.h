// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <atomic>
#include <functional>
#include <mutex>
#include <string>
#include <utility>

#include "core/process/process.h"
#include "core/process/process_status.h"

namespace plslam::bus {

/// Terminal output of a process that was started by hand, one sentence a line. Silent until `Begin`: a launcher prints
/// for the processes that it starts. Safe from any thread.
class ProcessTerminal {
 public:
  /// `program`: its name, in front of each line.
  void Begin(const std::string& program);
  void PrintLine(const std::string& words);
  /// Prints states that are not reported elsewhere: not "ready", not "stopping", and no failure.
  void ReportState(const std::string& state, const std::string& reason);

 private:
  void Print(const std::string& words) const;

  std::mutex mutex_;
  std::string program_;
  std::string state_;
  std::string reason_;
};

struct Process::Impl {
  Impl(const std::string& name, const BusOptions& options, Bus& bus,
       std::function<void(const std::string& sentence)> on_older)
      : status(name, options, bus, std::move(on_older)) {}

  StatusPublisher status;
  ProcessTerminal terminal;
  std::atomic<int> exit_code{0};
  bool has_launcher = false;
  /// Exit code if another process of this name has run for longer.
  int exit_code_of_namesake = 1;
  bool has_yielded = false;
  std::atomic<bool> finished{false};
};

}  // namespace plslam::bus
