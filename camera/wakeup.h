// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>
#include <condition_variable>
#include <mutex>
#include <utility>

namespace plslam::camera {

/// Lets a thread wait for an event on any other thread. A call before the wait ends it at once.
class Wakeup {
 public:
  void Call() {
    const std::scoped_lock lock(mutex_);
    called_ = true;
    changed_.notify_all();
  }
  void WaitFor(std::chrono::milliseconds limit) {
    std::unique_lock lock(mutex_);
    changed_.wait_for(lock, limit, [this] { return called_; });
    called_ = false;
  }

 private:
  std::mutex mutex_;
  std::condition_variable changed_;
  bool called_ = false;
};

}  // namespace plslam::camera
