// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <utility>

#include "core/bus/bus_impl.h"
#include "core/errors/log.h"
#include "plslam/announce_t.hpp"
#include "plslam/repair_request_t.hpp"

// The receiving thread of a bus.

namespace plslam::bus {
namespace {

/// `delivered` of requests about no channel.
constexpr int64_t kQuestion = -1;
constexpr int64_t kAnswer = 0;

/// Returns nullptr if there is no such channel.
const Channel* FindChannel(std::string_view name) {
  const auto rows = Channels();
  const auto found = std::find_if(rows.begin(), rows.end(), [&](const Channel& row) { return row.name == name; });
  return found == rows.end() ? nullptr : &*found;
}

/// Returns `repair_request_t.publisher` of a checked message, which follows the header and the string `channel`.
SourceId PublisherOf(ByteView request) {
  const uint8_t* p = request.data() + kWireHeaderBytes;
  return SourceId(ReadInt64(p + 4 + ReadInt32(p)));
}

}  // namespace

void Bus::Impl::MayReceive() {
  may_receive_ = true;
  may_receive_.notify_all();
}

void Bus::Impl::ReceiveLoop() {
  if (transport.kind() == Transport::Kind::kFileRead) may_receive_.wait(false);
  while (!stopping_) {
    const int64_t now = SteadyNow_ns();
    int64_t next = now + 100 * kMs;
    inboxes.Poll(now, next);
    for (const Outboxes::Announcement& due : outboxes.Poll(now, next)) Announce(due);
    wake_time_ = next;
    const int64_t wait = std::max<int64_t>(0, next - SteadyNow_ns());
    if (!transport.Receive(static_cast<int>((wait + kMs - 1) / kMs))) inboxes.OnEnd();
  }
}

bool Bus::Impl::Drop() {
  if (options.drop_fraction <= 0.0) return false;
  return static_cast<double>(drop_random_() >> 11) * 0x1p-53 < options.drop_fraction;
}

void Bus::Impl::OnDatagram(std::string_view wire_name, ByteView bytes) {
  const int64_t now = SteadyNow_ns();
  if (Drop()) return;
  NoticePrefix(wire_name, now);
  const bool is_request = names.IsNamed(wire_name, kRepairRequest);
  const bool is_announce = !is_request && names.IsNamed(wire_name, kAnnounce);
  const MessageLayout* subscribed = inboxes.LayoutOf(wire_name);
  if (subscribed == nullptr) inboxes.TakeRest(wire_name, bytes);
  const MessageLayout* layout = is_request ? request_layout_ : is_announce ? announce_layout_ : subscribed;
  if (layout == nullptr) return;
  const ByteView message = Checked(wire_name, *layout, bytes, now);
  if (message.empty()) return;
  ++counts.received;
  if (!IsAlive(wire_name, message, now)) return;
  if (is_request) OnRepairRequest(wire_name, message, now);
  if (is_announce) OnAnnounce(wire_name, message, now);
  if (subscribed != nullptr) inboxes.Dispatch(wire_name, ReadHeader(message), message, now);
}

void Bus::Impl::Reject(Rejection why, std::string_view wire_name, int64_t now) {
  ++counts.rejected;
  if (!rejections_.Count(why, wire_name, now)) return;
  const bool is_of_version = why == Rejection::kOtherVersion;
  LogWarning(
      "a message on {} was rejected: it is {}{}; later ones are counted only", wire_name, Rejections::Text(why),
      is_of_version ? " of plslam (run the same version everywhere; use `plslam replay` for logs of other versions)"
                    : "");
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

/// With a key: returns whether the message comes from a running process, and (requests and announcements, whose numbers
/// are not checked elsewhere) is no duplicate. Without a key, the source cannot be verified, and every message is
/// accepted.
bool Bus::Impl::IsAlive(std::string_view wire_name, ByteView message, int64_t now) {
  const WireHeader header = ReadHeader(message);
  if (!authenticator.has_key() || !transport.two_way() || header.source == source) return true;
  const SourceId sender = header.source;
  const bool is_request = names.IsNamed(wire_name, kRepairRequest);
  const bool is_announce = names.IsNamed(wire_name, kAnnounce);
  if ((is_request && !peers_.TakeRequest(sender, header.seq, now)) ||
      (is_announce && !peers_.TakeAnnouncement(sender, header.seq, now))) {
    ++counts.duplicates;
    return false;
  }
  if (is_request && PublisherOf(message) == source) peers_.Prove(sender, now);
  if (peers_.IsAlive(sender)) return true;
  const LivePeers::Doubt doubt = peers_.OnSignOfLife(sender, now);
  if (doubt.ask) SendHello(sender, true);
  ++counts.unproven;
  if (doubt.is_overdue) Reject(Rejection::kReplayed, wire_name, now);
  return false;
}

void Bus::Impl::NoticePrefix(std::string_view wire_name, int64_t now) {
  if (!wire_name.ends_with(kStatus.name) || names.IsNamed(wire_name, kStatus)) return;
  const std::string_view prefix = wire_name.substr(0, wire_name.size() - kStatus.name.size());
  if (rejections_.OtherPrefix(prefix, now)) LogInfo("{}", Rejections::PrefixText(prefix));
}

void Bus::Impl::OnRepairRequest(std::string_view wire_name, ByteView bytes, int64_t now) {
  const auto decoded = Decoded<repair_request_t>(bytes);
  if (!decoded) return;
  const repair_request_t& request = *decoded;
  if (request.channel.empty()) {
    const bool asks_us = request.publisher == source.value && request.delivered == kQuestion;
    if (asks_us && authenticator.has_key()) SendHello(SourceId(request.header.source), false);
    return;
  }
  const Channel* channel = FindChannel(request.channel);
  if (channel == nullptr || !names.IsAbout(*channel, wire_name, kRepairRequest)) return;
  if (request.publisher == 0) {
    const auto due = outboxes.OnHello(*channel, SourceId(request.header.source), request.window_bytes, now);
    if (due) Announce(*due);
    return;
  }
  if (request.publisher != source.value) return;
  std::vector<SeqRange> ranges;
  for (const range_t& range : request.ranges) ranges.push_back({range.first, range.last});
  const Outboxes::Answer answer = outboxes.OnRequest(request.channel, SourceId(request.header.source),
                                                     request.delivered, request.window_bytes, ranges, now);
  for (const Bytes& message : answer.resend) outboxes.SendRepairable(answer.wire_name, *message);
  if (answer.announcement) Announce(*answer.announcement);
}

void Bus::Impl::OnAnnounce(std::string_view wire_name, ByteView bytes, int64_t now) {
  const auto decoded = Decoded<announce_t>(bytes);
  if (!decoded) return;
  const announce_t& announce = *decoded;
  const Channel* channel = FindChannel(announce.channel);
  if (channel == nullptr || !names.IsAbout(*channel, wire_name, kAnnounce)) return;
  inboxes.OnAnnounce(names.WireName(*channel), SourceId(announce.header.source), announce.first_seq,
                     announce.next_seq, announce.join_seq, now);
}

/// "Do you live?" (a question) or "I do": names the other, which is proof enough for it.
void Bus::Impl::SendHello(SourceId peer, bool question) {
  repair_request_t message{};
  message.publisher = peer.value;
  message.delivered = question ? kQuestion : kAnswer;
  // Sent under the map's prefix, to which all processes that can exchange messages listen.
  SendControl(kRepairRequest, Scope::kMap, message);
}

void Bus::Impl::Announce(const Outboxes::Announcement& what) {
  announce_t announce{};
  announce.channel = what.channel.name;
  announce.next_seq = what.next_seq;
  announce.first_seq = what.first_seq;
  announce.join_seq = what.join_seq;
  if (transport.two_way()) SendControl(kAnnounce, what.channel.scope, announce);
}

void Bus::Impl::Request(const Channel& channel, SourceId publisher, const OrderedReader::Request& request) {
  repair_request_t message{};
  message.channel = channel.name;
  message.publisher = publisher.value;
  message.delivered = request.delivered;
  message.window_bytes = static_cast<int32_t>(std::min<int64_t>(transport.receive_window(), 1 << 30));
  for (const SeqRange& range : request.ranges) {
    range_t wire{};
    wire.first = range.first;
    wire.last = range.last;
    message.ranges.push_back(wire);
  }
  message.n_ranges = static_cast<int32_t>(message.ranges.size());
  SendControl(kRepairRequest, channel.scope, message);
}

template <class T>
void Bus::Impl::SendControl(const Channel& channel, Scope scope, T message) {
  message.header.schema = kSchemaVersion;
  message.header.source = source.value;
  message.header.seq = control_seq_[std::string(channel.name)]++;
  std::vector<uint8_t> bytes = Encoded(message);
  const std::string wire_name = std::string(names.PrefixOf(scope)).append(channel.name);
  authenticator.Append(wire_name, bytes);
  transport.Send(wire_name, bytes);
}

}  // namespace plslam::bus
