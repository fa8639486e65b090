// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <exception>
#include <functional>
#include <mutex>
#include <vector>

#include "core/bus/bus.h"

namespace plslam::bus {

/// Queue of things to do on one thread, and timers. Everything is safe from any thread; `Run` from one.
class RunLoop {
 public:
  using Clock = std::chrono::steady_clock;

  /// `bytes` is the memory that the task holds, for `queued_bytes`.
  void Post(std::function<void()> task, int64_t bytes = 0);
  void Every(std::chrono::milliseconds period, std::function<void()> task);
  /// Runs `task` once.
  void After(std::chrono::milliseconds delay, std::function<void()> task);

  /// Bytes held by tasks that have not run yet.
  int64_t queued_bytes() const { return queued_bytes_; }

  /// Runs tasks until `Stop`. Tasks that are queued then stay queued.
  void Run();
  void Stop();

 private:
  struct Task {
    std::function<void()> run;
    int64_t bytes = 0;
  };
  struct Timer {
    Clock::time_point due;
    std::chrono::milliseconds period{};  ///< 0: it runs once
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

/// For threads beside that of `Bus::Run`: runs `work`; an exception of it ends the process through the run loop.
template <class Work>
void RunGuarded(Bus& bus, const Work& work) {
  std::exception_ptr failure;
  try {
    work();
  } catch (...) {
    failure = std::current_exception();
  }
  // Only now, so that the exception is no longer this thread's too.
  if (failure) bus.Post([failure = std::move(failure)] { std::rethrow_exception(failure); });
}

/// Steady time, for durations.
inline double NowMs() {
  return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now().time_since_epoch()).count();
}
inline double NowS() { return 1e-3 * NowMs(); }

}  // namespace plslam::bus
