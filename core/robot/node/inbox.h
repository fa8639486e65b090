// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <mutex>
#include <optional>
#include <span>
#include <utility>
#include <vector>

namespace plslam::robot {

/// A queue of messages between the receiving thread and the working thread. If more messages wait than there is room
/// for, the oldest are dropped and counted. Safe from any thread.
class Inbox {
 public:
  struct Message {
    size_t channel = 0;
    std::vector<uint8_t> bytes;
  };

  explicit Inbox(size_t room) : room_(room) {}

  void Put(size_t channel, std::span<const uint8_t> bytes) {
    Message message{channel, {bytes.begin(), bytes.end()}};
    const std::scoped_lock lock(mutex_);
    if (waiting_.size() >= room_) {
      waiting_.pop_front();
      ++dropped_;
    }
    waiting_.push_back(std::move(message));
    changed_.notify_one();
  }

  /// Returns the oldest message; nullopt if none arrives within the time, and after `Stop`.
  std::optional<Message> Take(std::chrono::milliseconds limit) {
    std::unique_lock lock(mutex_);
    changed_.wait_for(lock, limit, [this] { return stopped_ || !waiting_.empty(); });
    if (stopped_ || waiting_.empty()) return std::nullopt;
    Message message = std::move(waiting_.front());
    waiting_.pop_front();
    return message;
  }

  void Stop() {
    const std::scoped_lock lock(mutex_);
    stopped_ = true;
    changed_.notify_all();
  }
  bool stopped() const {
    const std::scoped_lock lock(mutex_);
    return stopped_;
  }
  int64_t dropped() const {
    const std::scoped_lock lock(mutex_);
    return dropped_;
  }

 private:
  const size_t room_;
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<Message> waiting_;
  int64_t dropped_ = 0;
  bool stopped_ = false;
};

}  // namespace plslam::robot
