// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <list>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/bus/transport/wire.h"

namespace plslam::bus {

/// Of LCM, without the zero at its end.
inline constexpr size_t kMaxChannelBytes = 63;

/// A part of a message that LCM has cut because it is longer than a datagram. The first one carries the channel.
struct MessagePart {
  uint32_t number = 0;  ///< of the message, by its sender
  uint32_t message_bytes = 0;
  uint32_t offset = 0;
  uint16_t part = 0;
  std::string_view channel;  ///< of part 0
  ByteView bytes;
};

/// The part in a packet; nullopt where there is none, or one that cannot be.
std::optional<MessagePart> ParsePart(ByteView packet);

/// Puts parts together again. They must come in order, as they do unless one is lost, so that a message takes no more
/// memory than has come of it: who receives from a network cannot trust the size that a first part tells.
class LongMessages {
 public:
  struct Message {
    std::string channel;
    std::vector<uint8_t> bytes;
  };
  /// The largest message that is taken: two images of 16 million pixels in colour.
  static constexpr size_t kMaxBytes = 100'000'000;

  /// Messages of channels that are not wanted are passed over.
  explicit LongMessages(std::function<bool(std::string_view channel)> wanted) : wanted_(std::move(wanted)) {}

  /// `sender` tells the sockets apart that send. The message that this part completes.
  std::optional<Message> Add(uint64_t sender, const MessagePart& part);

  /// Messages that were begun and not completed.
  int64_t lost() const { return lost_; }
  /// Of all messages that are not complete.
  size_t bytes() const { return n_bytes_; }

 private:
  struct Open {
    uint64_t sender = 0;
    uint32_t number = 0;
    uint32_t message_bytes = 0;
    Message message;
  };
  using Place = std::list<Open>::iterator;

  void Begin(uint64_t sender, const MessagePart& part);
  void Lose(Place open);

  std::function<bool(std::string_view)> wanted_;
  std::list<Open> open_;  // each sender once, the one heard last behind
  size_t n_bytes_ = 0;
  int64_t lost_ = 0;
};

}  // namespace plslam::bus
