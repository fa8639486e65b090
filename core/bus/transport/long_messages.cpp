// SPDX-License-Identifier: BSD-3-Clause
#include "core/bus/transport/long_messages.h"

#include <algorithm>
#include <cstring>
#include <utility>

namespace plslam::bus {
namespace {

constexpr size_t kMostSenders = 64;
/// Limit for all incomplete messages together: two pairs of images of the largest size.
constexpr size_t kMostBytes = 2 * LongMessages::kMaxBytes;

uint32_t ReadWord(const uint8_t* p) { return static_cast<uint32_t>(ReadInt32(p)); }
uint16_t ReadHalf(const uint8_t* p) { return static_cast<uint16_t>(p[0] << 8 | p[1]); }

}  // namespace

std::optional<MessagePart> ParsePart(ByteView packet) {
  if (packet.size() <= kPartHeadBytes || ReadWord(packet.data()) != kPartMagic) return std::nullopt;
  MessagePart part;
  part.number = ReadWord(&packet[4]);
  part.message_bytes = ReadWord(&packet[8]);
  part.offset = ReadWord(&packet[12]);
  part.part = ReadHalf(&packet[16]);
  part.n_parts = ReadHalf(&packet[18]);
  part.bytes = packet.subspan(kPartHeadBytes);
  if (part.part == 0) {
    const void* end = std::memchr(part.bytes.data(), 0, std::min(part.bytes.size(), kMaxChannelBytes + 1));
    if (end == nullptr || part.offset != 0) return std::nullopt;
    const auto length = static_cast<size_t>(static_cast<const uint8_t*>(end) - part.bytes.data());
    part.channel = {reinterpret_cast<const char*>(part.bytes.data()), length};
    part.bytes = part.bytes.subspan(length + 1);
  }
  const bool fits = part.part < part.n_parts && uint64_t{part.offset} + part.bytes.size() <= part.message_bytes;
  return fits ? std::optional(part) : std::nullopt;
}

void LongMessages::Lose(Place open) {
  n_bytes_ -= open->message.bytes.size();
  ++lost_;
  open_.erase(open);
}

void LongMessages::Begin(uint64_t sender, const MessagePart& part) {
  if (part.message_bytes > kMaxBytes || !wanted_(part.channel)) return;
  if (open_.size() >= kMostSenders) Lose(open_.begin());
  open_.push_back({sender, part.number, part.message_bytes, {std::string(part.channel), {}}});
}

std::optional<LongMessages::Message> LongMessages::Add(uint64_t sender, const MessagePart& part) {
  auto open = std::find_if(open_.begin(), open_.end(), [&](const Open& o) { return o.sender == sender; });
  if (part.part == 0) {
    if (open != open_.end()) Lose(open);
    Begin(sender, part);
    open = open_.empty() || open_.back().sender != sender ? open_.end() : std::prev(open_.end());
  }
  if (open == open_.end()) return std::nullopt;
  const bool follows = open->number == part.number && open->message_bytes == part.message_bytes &&
                       open->message.bytes.size() == part.offset;
  if (!follows) {
    Lose(open);
    return std::nullopt;
  }
  std::vector<uint8_t>& bytes = open->message.bytes;
  bytes.insert(bytes.end(), part.bytes.begin(), part.bytes.end());
  n_bytes_ += part.bytes.size();
  if (bytes.size() == open->message_bytes) {
    n_bytes_ -= bytes.size();
    Message message = std::move(open->message);
    open_.erase(open);
    return message;
  }
  open_.splice(open_.end(), open_, open);
  while (n_bytes_ > kMostBytes) Lose(open_.begin());
  return std::nullopt;
}

}  // namespace plslam::bus
