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

#include "core/bus/transport/long_messages.h"
#include "core/bus/transport/wire.h"

namespace plslam::bus {

// A large message as parts of one packet each, for networks that lose packets. A datagram of 60,000 bytes is 41 packets,
// and if one of them is lost the kernel of each receiver keeps the others for 30 s (ipfrag_time); 4 MB of them
// (ipfrag_high_thresh), some thirty datagrams, and no large datagram arrives any more. Parts are LCM's own format for long
// messages, so that stock LCM programs read them.
//
// The number of a message in its parts: a mark that LCM's own numbers do not reach, a digest of the channel (by which
// receivers ignore parts of other channels), the message's number on its channel, and that of the attempt. To stock
// programs each attempt is another message; here all attempts complete the same one.

/// Largest size of the message's bytes in a part: with all heads it fits a packet of 1,500 bytes.
inline constexpr size_t kPartBytes = 1200;

/// Digest of a channel's name in the numbers of parts.
uint32_t ChannelDigest(std::string_view channel);
/// Number of the parts of message `seq` of a channel, in one attempt of sending it.
uint32_t PartsNumber(std::string_view channel, int64_t seq, uint32_t attempt);
/// Digest of the channel of such a number; nullopt for a number of another program.
std::optional<uint32_t> DigestOf(uint32_t number);
/// A number, shifted right by `kDigestShift`, is the digest and this mark.
inline constexpr uint32_t kDigestShift = 20;
inline constexpr uint32_t kDigestMark = uint32_t{1} << 11;

/// Calls `send` with each packet of the message.
void ForEachPart(std::string_view channel, ByteView message, uint32_t number,
                 const std::function<void(ByteView packet)>& send);

/// Reassembles parts that arrive in any order and in several attempts. A message that has got no part for `kPatience_ns`
/// is forgotten, before its number is used again. Time in nanoseconds of any steady clock; not thread-safe.
class PacketParts {
 public:
  static constexpr int64_t kPatience_ns = 5'000'000'000;
  /// Incomplete messages at a time; the oldest is forgotten first.
  static constexpr size_t kMostOpen = 128;

  /// `sender` identifies the sending socket. Returns the message that this part completes.
  std::optional<LongMessages::Message> Add(uint64_t sender, const MessagePart& part, int64_t now);

  size_t n_open() const { return open_.size(); }

 private:
  struct Open {
    uint64_t sender = 0;
    uint32_t number = 0;  ///< without the attempt
    int64_t heard = 0;
    LongMessages::Message message;
    std::vector<bool> has;  ///< parts that have arrived
    size_t n_missing = 0;
  };

  std::list<Open> open_;  // the most recent one last
};

}  // namespace plslam::bus
