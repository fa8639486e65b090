#pragma once

#include <csignal>
#include <functional>
#include <thread>

namespace plslam::bus {

/// Turns SIGINT and SIGTERM into a call on a thread of its own, where everything may be done (unlike in a handler).
///
/// Make it before other threads: they inherit the blocked signals. The first signal calls `on_stop`; a second one
/// ends the process at once, for a user whose process hangs. The destructor restores the mask.
class SignalWatcher {
 public:
  /// Throws std::runtime_error where the kernel refuses.
  explicit SignalWatcher(std::function<void(int signal)> on_stop);
  ~SignalWatcher();
  SignalWatcher(const SignalWatcher&) = delete;
  SignalWatcher& operator=(const SignalWatcher&) = delete;

 private:
  void Watch();

  std::function<void(int)> on_stop_;
  sigset_t previous_mask_{};
  int signal_fd_ = -1;
  int stop_fd_ = -1;
  std::thread thread_;
};

}  // namespace plslam::bus
