// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <sys/types.h>

#include <chrono>
#include <csignal>
#include <functional>
#include <optional>
#include <string>
#include <thread>

namespace plslam::bus {

/// Order of a launcher to a process that it has started (`--parent`). No user and no service manager sends this signal,
/// so a signal to a whole group of processes is not mistaken for the order.
inline constexpr int kStopOrder = SIGUSR1;

/// "SIGKILL"; "signal 40" for one without a name.
std::string SignalName(int signal);

/// Turns signals that stop a process into a call on a separate thread, in which all functions are allowed (unlike in a
/// handler).
///
/// Construct it before other threads: they inherit the blocked signals. The destructor restores the mask.
///
/// A process without a launcher is stopped by SIGINT, SIGTERM and SIGHUP (unless SIGHUP was ignored from the start, as
/// `nohup` does). The first signal calls `on_stop`; a second one ends the process at once, for a user whose process
/// hangs. Signals that arrive at the same moment count as one (`timeout` and shells send one to the process and one to
/// its group), and SIGHUP never counts as the second: a terminal that closes is not an impatient user.
///
/// A process that has a launcher is stopped by `kStopOrder` only, as long as the launcher runs: a signal to the
/// launcher and all its processes is an order to the launcher, which may still need them. When the launcher has exited,
/// SIGTERM (from the kernel) stops the process, which then has a minute to end.
class SignalWatcher {
 public:
  /// `on_stop` receives the name of the signal. `launcher` is the process that started this one; 0: none.
  /// `before_the_end` is called before a second signal ends the process; it may be empty. Throws std::runtime_error if
  /// the kernel refuses.
  explicit SignalWatcher(std::function<void(const std::string& signal)> on_stop, pid_t launcher = 0,
                         std::function<void()> before_the_end = {});
  ~SignalWatcher();
  SignalWatcher(const SignalWatcher&) = delete;
  SignalWatcher& operator=(const SignalWatcher&) = delete;

 private:
  using Clock = std::chrono::steady_clock;

  void Watch();
  void Take(int signal);
  void EndAtOnce(int signal) const;
  void TakePending() const;

  std::function<void(const std::string&)> on_stop_;
  pid_t launcher_;
  std::function<void()> before_the_end_;
  sigset_t previous_mask_{};
  int signal_fd_ = -1;
  int stop_fd_ = -1;
  bool stopping_ = false;  // these two are the watching thread's
  Clock::time_point last_at_;
  std::thread thread_;
};

}  // namespace plslam::bus
