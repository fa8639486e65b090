// SPDX-License-Identifier: BSD-3-Clause
#include <spdlog/spdlog.h>

#include "core/bus/bus_impl.h"

namespace plslam::bus {
namespace {

/// `repair_request_t.publisher` of a checked message: behind the header and the string `channel`.
int64_t PublisherOf(ByteView request) {
  const uint8_t* p = request.data() + kWireHeaderBytes;
  return ReadInt64(p + 4 + ReadInt32(p));
}

}  // namespace

void Bus::Impl::Reject(Rejection why, std::string_view wire_name, int64_t now) {
  ++counts.rejected;
  if (!rejections.Count(why, wire_name, now)) return;
  spdlog::warn("a message on {} was rejected: it is {}; more of the kind are only counted", wire_name,
               Rejections::Text(why));
}

std::optional<Rejection> Bus::Impl::WhyNot(std::string_view wire_name, const MessageLayout& layout, ByteView bytes,
                                           size_t* length) const {
  if (bytes.size() > kMaxMessageBytes) return Rejection::kOversized;
  if (bytes.size() < kWireHeaderBytes) return Rejection::kMalformed;
  if (ReadInt64(bytes.data()) != layout.fingerprint()) return Rejection::kOtherVersion;
  const auto message = MessageLength(layout, bytes);
  if (!message || *message < kWireHeaderBytes) return Rejection::kMalformed;
  *length = *message;
  if (!authenticator.Accept(wire_name, bytes, *message)) {
    if (bytes.size() == *message) return Rejection::kNoKey;
    return bytes.size() == *message + Authenticator::kMacBytes ? Rejection::kOtherKey : Rejection::kMalformed;
  }
  const WireHeader header = ReadHeader(bytes);
  if (header.schema != kSchemaVersion) return Rejection::kOtherSchema;
  if (header.source == 0 || header.seq < 0 || header.seq > kMaxNumber) return Rejection::kMalformed;
  return std::nullopt;
}

ByteView Bus::Impl::Checked(std::string_view wire_name, const MessageLayout& layout, ByteView bytes, int64_t now) {
  size_t length = 0;
  const auto why = WhyNot(wire_name, layout, bytes, &length);
  if (!why) return bytes.first(length);
  Reject(*why, wire_name, now);
  return {};
}

/// With a key: whether the message comes from a process that lives, and (requests and announcements, whose numbers
/// nobody else looks at) for the first time. Without a key anybody can claim to live.
bool Bus::Impl::Lives(std::string_view wire_name, ByteView message, int64_t now) {
  const WireHeader header = ReadHeader(message);
  if (!authenticator.has_key() || !transport.two_way() || header.source == source) return true;
  const bool is_request = IsNamed(wire_name, kRepairRequest), is_announce = IsNamed(wire_name, kAnnounce);
  if ((is_request && !peers.TakeRequest(header.source, header.seq, now)) ||
      (is_announce && !peers.TakeAnnouncement(header.source, header.seq, now))) {
    ++counts.duplicates;
    return false;
  }
  if (is_request && PublisherOf(message) == source) peers.Prove(header.source, now);
  if (peers.Lives(header.source)) return true;
  const LivePeers::Doubt doubt = peers.Hear(header.source, now);
  if (doubt.ask) Greet(header.source, true);
  ++counts.unproven;
  if (doubt.forlorn) Reject(Rejection::kReplayed, wire_name, now);
  return false;
}

void Bus::Impl::NoticePrefix(std::string_view wire_name, int64_t now) {
  if (!wire_name.ends_with(kStatus.name) || IsNamed(wire_name, kStatus)) return;
  const std::string_view prefix = wire_name.substr(0, wire_name.size() - kStatus.name.size());
  if (rejections.OtherPrefix(prefix, now)) spdlog::info("{}", Rejections::PrefixText(prefix));
}

}  // namespace plslam::bus
