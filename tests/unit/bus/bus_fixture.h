// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <memory>
#include <mutex>
#include <string>
#include <thread>

#include "core/bus/bus.h"
#include "tests/support/sanitized.h"

namespace plslam::bus::test {

/// Returns a new udpm URL for each call: a random multicast group and port that never leave the host.
std::string PrivateUrl();

/// Runs a shell command; returns its exit code.
int Shell(const std::string& command);
bool HasProgram(const std::string& name);

/// A folder that is removed with this object.
class TemporaryFolder {
 public:
  TemporaryFolder();
  ~TemporaryFolder();
  std::string operator/(const std::string& name) const { return path_ + "/" + name; }
  const std::string& path() const { return path_; }

 private:
  std::string path_;
};

/// Counts up from handlers; tests wait for a value instead of sleeping.
class Waiter {
 public:
  void Add(int64_t n = 1) {
    {
      const std::lock_guard lock(mutex_);
      value_ += n;
    }
    changed_.notify_all();
  }

  /// Returns true when the value reaches `n` within the limit.
  bool Reaches(int64_t n, std::chrono::milliseconds limit = std::chrono::seconds(20)) {
    std::unique_lock lock(mutex_);
    return changed_.wait_for(lock, plslam::test::Patience(limit), [&] { return value_ >= n; });
  }

  int64_t value() const {
    const std::lock_guard lock(mutex_);
    return value_;
  }

 private:
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  int64_t value_ = 0;
};

/// A bus whose handlers run on a separate thread.
class RunningBus {
 public:
  explicit RunningBus(const BusOptions& options, const std::string& name = "test") : bus_(options, name) {}
  ~RunningBus() { Join(); }

  Bus& operator*() { return bus_; }
  Bus* operator->() { return &bus_; }

  /// Subscribe first.
  void Start() {
    thread_ = std::thread([this] { bus_.Run(); });
  }
  void Join() {
    bus_.Stop();
    if (thread_.joinable()) thread_.join();
  }

 private:
  Bus bus_;
  std::thread thread_;
};

/// Waits until `publisher` has `n` readers of `channel`.
bool WaitForReaders(Bus& publisher, const Channel& channel, int n);

/// Waits until `condition` holds, by polling; for counters without an event.
template <class Condition>
bool Eventually(Condition condition, std::chrono::milliseconds limit = std::chrono::seconds(20)) {
  const auto deadline = std::chrono::steady_clock::now() + plslam::test::Patience(limit);
  while (!condition()) {
    if (std::chrono::steady_clock::now() > deadline) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  return true;
}

}  // namespace plslam::bus::test
