// SPDX-License-Identifier: BSD-3-Clause
#include "loop_process/node/adjustment_slot.h"

#include <utility>

namespace plslam::loop {

void AdjustmentSlot::Put(GlobalBundleProblem problem) {
  {
    const std::lock_guard lock(mutex_);
    next_ = std::move(problem);
    interrupts_ = true;
  }
  changed_.notify_all();
}

void AdjustmentSlot::Drop(bool with_progress) {
  const std::lock_guard lock(mutex_);
  forgets_progress_ |= with_progress;
  next_.reset();
  interrupts_ = true;
  ++n_dropped_;
}

std::optional<AdjustmentSlot::Job> AdjustmentSlot::Take() {
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [this] { return stopped_ || next_; });
  if (stopped_) return std::nullopt;
  interrupts_ = false;
  Job job{std::move(*next_), std::exchange(forgets_progress_, false), n_dropped_};
  next_.reset();
  return job;
}

AdjustmentSlot::Outcome AdjustmentSlot::OutcomeOf(const Job& job) const {
  const std::lock_guard lock(mutex_);
  if (stopped_) return Outcome::kStopped;
  return next_ || n_dropped_ != job.n_dropped ? Outcome::kOutdated : Outcome::kCurrent;
}

void AdjustmentSlot::Stop() {
  {
    const std::lock_guard lock(mutex_);
    stopped_ = true;
    interrupts_ = true;
  }
  changed_.notify_all();
}

}  // namespace plslam::loop
