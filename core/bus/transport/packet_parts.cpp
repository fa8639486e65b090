// SPDX-License-Identifier: BSD-3-Clause
#include "core/bus/transport/packet_parts.h"

#include <algorithm>
#include <utility>

namespace plslam::bus {
namespace {

constexpr uint32_t kMark = uint32_t{1} << 31;
constexpr uint32_t kDigestBits = 11;
constexpr uint32_t kSeqBits = 14;
constexpr uint32_t kAttemptBits = 6;
static_assert(1 + kDigestBits + kSeqBits + kAttemptBits == 32);
static_assert(kSeqBits + kAttemptBits == kDigestShift && kMark >> kDigestShift == kDigestMark);

constexpr uint32_t Mask(uint32_t bits) { return (uint32_t{1} << bits) - 1; }

void AppendWord(std::vector<uint8_t>& to, uint32_t word) {
  for (const int shift : {24, 16, 8, 0}) to.push_back(static_cast<uint8_t>(word >> shift));
}

void AppendHalf(std::vector<uint8_t>& to, uint32_t half) {
  for (const int shift : {8, 0}) to.push_back(static_cast<uint8_t>(half >> shift));
}

/// Bytes of the message in the first part, beside the channel's name.
size_t FirstBytes(size_t channel_bytes) { return kPartBytes - channel_bytes - 1; }

size_t PartCount(size_t message_bytes, size_t channel_bytes) {
  const size_t first = FirstBytes(channel_bytes);
  return message_bytes <= first ? 1 : 1 + (message_bytes - first + kPartBytes - 1) / kPartBytes;
}

}  // namespace

uint32_t ChannelDigest(std::string_view channel) {
  uint32_t digest = 2166136261U;  // FNV-1a
  for (const char c : channel) digest = (digest ^ static_cast<unsigned char>(c)) * 16777619U;
  return (digest ^ digest >> kDigestBits ^ digest >> (2 * kDigestBits)) & Mask(kDigestBits);
}

uint32_t PartsNumber(std::string_view channel, int64_t seq, uint32_t attempt) {
  const auto number = static_cast<uint32_t>(static_cast<uint64_t>(seq)) & Mask(kSeqBits);
  return kMark | ChannelDigest(channel) << (kSeqBits + kAttemptBits) | number << kAttemptBits |
         (attempt & Mask(kAttemptBits));
}

std::optional<uint32_t> DigestOf(uint32_t number) {
  if ((number & kMark) == 0) return std::nullopt;
  return number >> (kSeqBits + kAttemptBits) & Mask(kDigestBits);
}

void ForEachPart(std::string_view channel, ByteView message, uint32_t number,
                 const std::function<void(ByteView)>& send) {
  const size_t n = PartCount(message.size(), channel.size());
  size_t offset = 0;
  std::vector<uint8_t> packet;
  packet.reserve(kPartBytes + kPartHeadBytes);
  for (size_t part = 0; part < n; ++part) {
    packet.clear();
    AppendWord(packet, kPartMagic);
    AppendWord(packet, number);
    AppendWord(packet, static_cast<uint32_t>(message.size()));
    AppendWord(packet, static_cast<uint32_t>(offset));
    AppendHalf(packet, static_cast<uint32_t>(part));
    AppendHalf(packet, static_cast<uint32_t>(n));
    if (part == 0) {
      packet.insert(packet.end(), channel.begin(), channel.end());
      packet.push_back(0);
    }
    const size_t room = part == 0 ? FirstBytes(channel.size()) : kPartBytes;
    const ByteView bytes = message.subspan(offset, std::min(room, message.size() - offset));
    packet.insert(packet.end(), bytes.begin(), bytes.end());
    offset += bytes.size();
    send(packet);
  }
}

std::optional<LongMessages::Message> PacketParts::Add(uint64_t sender, const MessagePart& part, int64_t now) {
  if (part.message_bytes > kMaxMessageBytes || part.n_parts == 0) return std::nullopt;
  while (!open_.empty() && now - open_.front().heard > kPatience_ns) open_.pop_front();
  const uint32_t number = part.number & ~Mask(kAttemptBits);
  auto open = std::find_if(open_.begin(), open_.end(),
                           [&](const Open& o) { return o.sender == sender && o.number == number; });
  // Another message of the same number: the earlier one is out of date.
  if (open != open_.end() && (open->message.bytes.size() != part.message_bytes || open->has.size() != part.n_parts)) {
    open_.erase(open);
    open = open_.end();
  }
  if (open == open_.end()) {
    if (open_.size() == kMostOpen) open_.pop_front();
    open_.push_back({sender,
                     number,
                     now,
                     {{}, std::vector<uint8_t>(part.message_bytes)},
                     std::vector<bool>(part.n_parts),
                     part.n_parts});
    open = std::prev(open_.end());
  }
  open_.splice(open_.end(), open_, open);
  open->heard = now;
  if (open->has[part.part]) return std::nullopt;
  open->has[part.part] = true;
  --open->n_missing;
  if (part.part == 0) open->message.channel = part.channel;
  std::copy(part.bytes.begin(), part.bytes.end(), open->message.bytes.begin() + part.offset);
  if (open->n_missing > 0) return std::nullopt;
  LongMessages::Message message = std::move(open->message);
  open_.erase(open);
  return message;
}

}  // namespace plslam::bus
