// SPDX-License-Identifier: BSD-3-Clause
#include "loop_process/node/arrival_queue.h"

#include <utility>

namespace plslam::loop {
namespace {

// Length above which `Add` blocks, and the longest it blocks for one arrival, so that statuses still go out.
constexpr size_t kMostArrivals = 2000;
constexpr std::chrono::milliseconds kHold(200);

}  // namespace

void ArrivalQueue::Open(const StereoCamera& camera) {
  const std::lock_guard lock(mutex_);
  if (state_ != State::kClosed) return;
  state_ = State::kOpen;
  camera_ = camera;
}

bool ArrivalQueue::is_open() const {
  const std::lock_guard lock(mutex_);
  return state_ == State::kOpen;
}

bool ArrivalQueue::HasRoom() const { return state_ != State::kOpen || arrivals_.size() < kMostArrivals; }

void ArrivalQueue::Add(Arrival arrival) {
  {
    std::unique_lock lock(mutex_);
    changed_.wait_for(lock, kHold, [this] { return HasRoom(); });
    arrivals_.push_back(std::move(arrival));
    Count(arrivals_.back(), 1);
  }
  changed_.notify_all();
}

std::optional<Arrival> ArrivalQueue::Take(std::chrono::milliseconds limit) {
  std::unique_lock lock(mutex_);
  const auto has_any = [this] { return state_ == State::kOpen && !arrivals_.empty(); };
  changed_.wait_for(lock, limit, [&] { return state_ == State::kStopped || has_any(); });
  if (!has_any()) return std::nullopt;
  const bool was_full = !HasRoom();
  std::optional<Arrival> arrival = std::move(arrivals_.front());
  arrivals_.pop_front();
  Count(*arrival, -1);
  if (was_full) changed_.notify_all();
  return arrival;
}

StereoCamera ArrivalQueue::camera() const {
  const std::lock_guard lock(mutex_);
  return camera_.value();
}

void ArrivalQueue::Stop() {
  {
    const std::lock_guard lock(mutex_);
    state_ = State::kStopped;
  }
  changed_.notify_all();
}

bool ArrivalQueue::stopped() const {
  const std::lock_guard lock(mutex_);
  return state_ == State::kStopped;
}

void ArrivalQueue::Count(const Arrival& arrival, int more) {
  if (std::holds_alternative<Keyframe>(arrival)) n_keyframes_ += more;
  process_.SetCounter("queue.arrivals", static_cast<double>(arrivals_.size()));
  process_.SetCounter("queue.keyframes", static_cast<double>(n_keyframes_));
}

}  // namespace plslam::loop
