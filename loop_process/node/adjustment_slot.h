// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <optional>

#include "loop_process/global_bundle.h"

namespace plslam::loop {

/// The next global bundle adjustment, between the checking worker, which finds loops, and the adjusting one. A new
/// problem, or a loop that makes the running adjustment obsolete, interrupts it. Safe from any thread.
class AdjustmentSlot {
 public:
  /// A problem that has been taken.
  struct Job {
    GlobalBundleProblem problem;
    bool forgets_progress = false;  ///< that of earlier adjustments must not be used
    int64_t n_dropped = 0;
  };
  enum class Outcome {
    kCurrent,   ///< the result may be published
    kOutdated,  ///< a later loop has made it obsolete
    kStopped,   ///< the process ends
  };

  /// Replaces a waiting problem.
  void Put(GlobalBundleProblem problem);
  /// The running or waiting adjustment is obsolete, and `with_progress` its progress, too.
  void Drop(bool with_progress);
  /// Waits for a problem; nullopt if the process ends.
  std::optional<Job> Take();
  Outcome OutcomeOf(const Job& job) const;
  void Stop();

  /// Set while the running adjustment is to end.
  const std::atomic<bool>& interrupts() const { return interrupts_; }

 private:
  mutable std::mutex mutex_;  // guards all but the atomic
  std::condition_variable changed_;
  std::optional<GlobalBundleProblem> next_;
  bool forgets_progress_ = false;  ///< the next adjustment starts without the progress of earlier ones
  int64_t n_dropped_ = 0;
  bool stopped_ = false;
  std::atomic<bool> interrupts_{false};
};

}  // namespace plslam::loop
