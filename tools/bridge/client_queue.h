// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <utility>

namespace plslam::bridge {

/// A WebSocket message to a client: text, or binary.
struct OutFrame {
  std::string head;  ///< before the payload; all of a text
  std::shared_ptr<const std::string> payload;
  bool is_binary = false;

  size_t size() const { return head.size() + (payload ? payload->size() : 0); }
};

/// Messages that wait for a client. A slow one loses images, maps and paths first: of each subscription to such a topic
/// only the newest message waits, and they are sent after all others. Poses, transforms and texts are never dropped: a
/// client that does not take them for so long that `kMostBytes` wait is disconnected.
class ClientQueue {
 public:
  static constexpr size_t kMostBytes = 16 << 20;

  void PutEvery(OutFrame frame) {
    every_bytes_ += frame.size();
    every_.push_back(std::move(frame));
  }
  void PutNewest(uint32_t subscription, OutFrame frame) {
    for (auto& [id, waiting] : newest_) {
      if (id != subscription) continue;
      waiting = std::move(frame);
      ++n_dropped_;
      return;
    }
    newest_.emplace_back(subscription, std::move(frame));
  }
  /// Drops what waits for a subscription that has ended.
  void Forget(uint32_t subscription) {
    std::erase_if(newest_, [&](const auto& waiting) { return waiting.first == subscription; });
  }

  std::optional<OutFrame> Take() {
    std::optional<OutFrame> frame;
    if (!every_.empty()) {
      frame = std::move(every_.front());
      every_.pop_front();
      every_bytes_ -= frame->size();
    } else if (!newest_.empty()) {
      frame = std::move(newest_.front().second);
      newest_.pop_front();
    }
    return frame;
  }
  bool empty() const { return every_.empty() && newest_.empty(); }
  bool is_too_slow() const { return every_bytes_ > kMostBytes; }
  int64_t n_dropped() const { return n_dropped_; }

 private:
  std::deque<OutFrame> every_;
  std::deque<std::pair<uint32_t, OutFrame>> newest_;
  size_t every_bytes_ = 0;
  int64_t n_dropped_ = 0;
};

}  // namespace plslam::bridge
