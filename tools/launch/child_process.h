// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <sys/types.h>

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace plslam::launcher {

/// The sender of signals that end a process.
enum class EndedBy {
  kAnybody,   ///< any sender of a signal
  kLauncher,  ///< this launcher only: SIGINT, SIGTERM and SIGHUP are blocked until the process handles them
              ///< (bus::SignalWatcher)
};

/// Exit status and resource usage of a process.
struct ChildExit {
  int code = 0;    ///< exit code, or 128 + signal as in shells
  int signal = 0;  ///< that ended it; 0: it ended by itself
  double cpu_s = 0.0;
  double peak_memory_mb = 0.0;  ///< as of the last `Poll` while it ran
};

/// A running program in a separate process group (a Ctrl-C on the terminal reaches only the launcher, which then stops
/// its children in order). Standard output and errors are appended to a file; no other descriptor of ours is inherited.
class ChildProcess {
 public:
  /// `niceness` is added to our own: 0 is our own priority, 19 runs only on an idle CPU. Throws std::runtime_error that
  /// names the program if it cannot be started.
  ChildProcess(const std::filesystem::path& program, const std::vector<std::string>& arguments,
               const std::filesystem::path& log, int niceness = 0, EndedBy ended_by = EndedBy::kAnybody);
  /// Kills the process if it still runs.
  ~ChildProcess();
  ChildProcess(const ChildProcess&) = delete;
  ChildProcess& operator=(const ChildProcess&) = delete;

  pid_t pid() const { return pid_; }
  /// Returns nullopt while it runs.
  std::optional<ChildExit> Poll();
  void Signal(int signal) const;

 private:
  std::optional<ChildExit> Wait(int options);

  pid_t pid_ = -1;
  std::optional<ChildExit> exit_;
  std::optional<double> peak_memory_mb_;
};

}  // namespace plslam::launcher
