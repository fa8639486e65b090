// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <condition_variable>
#include <functional>
#include <mutex>
#include <thread>

namespace plslam::vo {

/// A thread for the right image while the caller processes the left one. It avoids the core of the caller, because a
/// scheduler that packs threads (virtual machines, power saving) would let the two take turns.
class SideWorker {
 public:
  SideWorker();
  ~SideWorker();
  SideWorker(const SideWorker&) = delete;
  SideWorker& operator=(const SideWorker&) = delete;

  /// Runs `here` on the calling thread and `there` on the worker's, and returns when both are done. If the worker has
  /// not started when `here` is done (its core is busy), the caller runs `there`, too. Rethrows their exceptions,
  /// `here`'s first.
  void RunBoth(const std::function<void()>& here, const std::function<void()>& there);

 private:
  void Loop();
  void AvoidCurrentCore();

  std::mutex mutex_;
  std::condition_variable changed_;
  const std::function<void()>* job_ = nullptr;  ///< not started yet
  bool working_ = false;
  std::exception_ptr error_;
  bool stopping_ = false;
  int avoided_core_ = -1;
  std::thread thread_;
};

}  // namespace plslam::vo
