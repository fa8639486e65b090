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

/// Longest channel name of LCM, without its terminating zero.
inline constexpr size_t kMaxChannelBytes = 63;

/// Begin of a part: magic, number, length of the message, offset (32 bits each), part, parts (16 bits each).
inline constexpr uint32_t kPartMagic = 0x4c433033;
inline constexpr size_t kPartHeadBytes = 20;

/// A part of a message that LCM has split because it is longer than a datagram. The first one carries the channel.
struct MessagePart {
  uint32_t number = 0;  ///< of the message, by its sender
  uint32_t message_bytes = 0;
  uint32_t offset = 0;
  uint16_t part = 0;
  uint16_t n_parts = 0;
  std::string_view channel;  ///< of part 0
  ByteView bytes;
};

/// Returns the part in a packet; nullopt if it has none, or an invalid one.
std::optional<MessagePart> ParsePart(ByteView packet);

/// Reassembles parts. They must arrive in order, as they do unless one is lost, so that a message takes no more memory
/// than the parts received: the size in a first part from the network is not trusted.
class LongMessages {
 public:
  struct Message {
    std::string channel;
    std::vector<uint8_t> bytes;
  };
  /// The largest message that is taken: two images of 16 million pixels in colour.
  static constexpr size_t kMaxBytes = 100'000'000;

  /// Messages of channels that are not wanted are ignored.
  explicit LongMessages(std::function<bool(std::string_view channel)> wanted) : wanted_(std::move(wanted)) {}

  /// `sender` identifies the sending socket. Returns the message that this part completes.
  std::optional<Message> Add(uint64_t sender, const MessagePart& part);

  /// Messages that were begun and not completed.
  int64_t lost() const { return lost_; }
  /// Size of all incomplete messages.
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
  std::list<Open> open_;  // each sender once, the most recent one last
  size_t n_bytes_ = 0;
  int64_t lost_ = 0;
};

}  // namespace plslam::bus
