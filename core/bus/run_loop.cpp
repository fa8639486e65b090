// SPDX-License-Identifier: BSD-3-Clause
#include "core/bus/run_loop.h"

#include <algorithm>
#include <utility>

namespace plslam::bus {

void RunLoop::Post(std::function<void()> task, int64_t bytes) {
  {
    const std::lock_guard lock(mutex_);
    tasks_.push_back({std::move(task), bytes});
    queued_bytes_ += bytes;
  }
  changed_.notify_one();
}

void RunLoop::Every(std::chrono::milliseconds period, std::function<void()> task) {
  {
    const std::lock_guard lock(mutex_);
    timers_.push_back({Clock::now() + period, period, std::move(task)});
  }
  changed_.notify_one();
}

void RunLoop::After(std::chrono::milliseconds delay, std::function<void()> task) {
  {
    const std::lock_guard lock(mutex_);
    timers_.push_back({Clock::now() + delay, {}, std::move(task)});
  }
  changed_.notify_one();
}

void RunLoop::Stop() {
  {
    const std::lock_guard lock(mutex_);
    stopped_ = true;
  }
  changed_.notify_all();
}

void RunLoop::Run() {
  std::unique_lock lock(mutex_);
  while (!stopped_) {
    // Timers first, or a flood of messages would keep the status of a process from going out.
    const bool timer_ran = RunTimer(lock);
    if (stopped_) return;
    const bool task_ran = RunTask(lock);
    if (!timer_ran && !task_ran && !stopped_) Wait(lock);
  }
}

bool RunLoop::RunTask(std::unique_lock<std::mutex>& lock) {
  if (tasks_.empty()) return false;
  Task task = std::move(tasks_.front());
  tasks_.pop_front();
  lock.unlock();
  task.run();
  task.run = nullptr;  // its captures are destroyed outside the lock
  lock.lock();
  queued_bytes_ -= task.bytes;
  return true;
}

bool RunLoop::RunTimer(std::unique_lock<std::mutex>& lock) {
  const Clock::time_point now = Clock::now();
  for (size_t i = 0; i < timers_.size(); ++i) {
    Timer& timer = timers_[i];
    if (timer.due > now) continue;
    // One run however late: a process that was stopped for a while does not catch up a hundred status messages.
    timer.due = std::max(timer.due + timer.period, now);
    if (timer.period == std::chrono::milliseconds::zero()) {
      const std::function<void()> task = std::move(timer.task);
      timers_.erase(timers_.begin() + static_cast<std::ptrdiff_t>(i));
      lock.unlock();
      task();
      lock.lock();
      return true;
    }
    lock.unlock();
    timer.task();
    lock.lock();
    return true;
  }
  return false;
}

void RunLoop::Wait(std::unique_lock<std::mutex>& lock) {
  if (timers_.empty()) {
    changed_.wait(lock);
    return;
  }
  const auto first =
      std::min_element(timers_.begin(), timers_.end(), [](const Timer& a, const Timer& b) { return a.due < b.due; });
  changed_.wait_until(lock, first->due);
}

}  // namespace plslam::bus
