// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <sys/types.h>

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace plslam::launcher {

/// Who ends a process, beside itself.
enum class EndedBy {
  kAnybody,  ///< whoever sends it a signal
  kLauncher,  ///< us alone: SIGINT, SIGTERM and SIGHUP wait, blocked, until the process deals with them (bus::SignalWatcher)
};

/// How a process ended, and what it used.
struct ChildExit {
  int code = 0;    ///< exit code, or 128 + signal as shells count
  int signal = 0;  ///< that ended it; 0: it ended by itself
  double cpu_s = 0.0;
  double peak_memory_mb = 0.0;  ///< as of the last `Poll` while it ran
};

/// A running program in a process group of its own (a Ctrl-C on the terminal reaches only the launcher, which then
/// stops its children in order). Standard output and errors are appended to a file; nothing else of ours is
/// inherited.
class ChildProcess {
 public:
  /// `niceness` is added to our own: 0 is as important as we are, 19 runs when nobody else wants to. Throws
  /// std::runtime_error that names the program where it cannot be started.
  ChildProcess(const std::filesystem::path& program, const std::vector<std::string>& arguments,
               const std::filesystem::path& log, int niceness = 0, EndedBy ended_by = EndedBy::kAnybody);
  /// Kills it where it still runs.
  ~ChildProcess();
  ChildProcess(const ChildProcess&) = delete;
  ChildProcess& operator=(const ChildProcess&) = delete;

  pid_t pid() const { return pid_; }
  /// Nothing while it runs.
  std::optional<ChildExit> Poll();
  void Signal(int signal) const;

 private:
  std::optional<ChildExit> Wait(int options);

  pid_t pid_ = -1;
  std::optional<ChildExit> exit_;
  std::optional<double> peak_memory_mb_;
};

}  // namespace plslam::launcher
