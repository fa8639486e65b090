// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <functional>
#include <mutex>
#include <vector>

namespace plslam::bus {

/// Queue of things to do on one thread, and timers. Everything is safe from any thread; `Run` from one.
class RunLoop {
 public:
  using Clock = std::chrono::steady_clock;

  /// `bytes` is what the task holds in memory, for `queued_bytes`.
  void Post(std::function<void()> task, int64_t bytes = 0);
  void Every(std::chrono::milliseconds period, std::function<void()> task);

  /// Bytes held by tasks that have not run yet.
  int64_t queued_bytes() const { return queued_bytes_; }

  /// Runs tasks until `Stop`. What is queued then stays queued.
  void Run();
  void Stop();

 private:
  struct Task {
    std::function<void()> run;
    int64_t bytes = 0;
  };
  struct Timer {
    Clock::time_point due;
    std::chrono::milliseconds period{};
    std::function<void()> task;
  };

  bool RunTask(std::unique_lock<std::mutex>& lock);
  bool RunTimer(std::unique_lock<std::mutex>& lock);
  void Wait(std::unique_lock<std::mutex>& lock);

  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<Task> tasks_;
  std::deque<Timer> timers_;  // a deque: a task may add one while another runs
  std::atomic<int64_t> queued_bytes_ = 0;
  bool stopped_ = false;
};

}  // namespace plslam::bus
