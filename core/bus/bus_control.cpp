// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>

#include "core/bus/bus_impl.h"
#include "core/bus/transport/wire.h"
#include "plslam/announce_t.hpp"
#include "plslam/repair_request_t.hpp"

namespace plslam::bus {
namespace {

constexpr int64_t kHelloPeriod = 300 * kMs;
/// How soon a reader looks again whether its handlers have caught up.
constexpr int64_t kStalledPeriod = 2 * kMs;
/// `delivered` of requests about no channel.
constexpr int64_t kQuestion = -1;
constexpr int64_t kAnswer = 0;

/// nullptr: no such channel.
const Channel* FindChannel(std::string_view name) {
  const auto rows = Channels();
  const auto found = std::find_if(rows.begin(), rows.end(), [&](const Channel& row) { return row.name == name; });
  return found == rows.end() ? nullptr : &*found;
}

}  // namespace

/// Whether a request or announcement that came as `wire_name` can speak of our channel. Members called `channel` hold
/// names without prefix: what comes under the map's may be about the same channel of another robot, or of the map's
/// owner.
bool Bus::Impl::IsAbout(const Channel& channel, std::string_view wire_name, const Channel& control) const {
  const std::string& prefix = PrefixOf(channel.scope);
  return wire_name.size() == prefix.size() + control.name.size() && wire_name.starts_with(prefix);
}

void Bus::Impl::OnHello(const Channel& channel, int64_t reader, Hello hello) {
  Hellos& known = hellos[std::string(channel.name)];
  std::erase_if(known, [&](const auto& e) { return hello.heard - e.second.heard > kRemembered; });
  if (known.size() < kMaxReaders || known.contains(reader)) known[reader] = hello;
  const auto found = outboxes.find(channel.name);
  if (found == outboxes.end() || found->second->writer == nullptr) return;
  OrderedWriter& writer = *found->second->writer;
  writer.OnHello(reader, hello.window, hello.heard);
  const bool ordered = found->second->channel.delivery == Delivery::kEvery;
  if (ordered && writer.AnnounceDue(hello.heard)) Announce(*found->second);
}

void Bus::Impl::OnRepairRequest(std::string_view wire_name, ByteView bytes, int64_t now) {
  const auto decoded = Decoded<repair_request_t>(bytes);
  if (!decoded) return;
  const repair_request_t& request = *decoded;
  if (request.channel.empty()) return OnGreeting(request.header.source, request.publisher, request.delivered);
  const Channel* channel = FindChannel(request.channel);
  if (channel == nullptr || !IsAbout(*channel, wire_name, kRepairRequest)) return;
  if (request.publisher == 0) return OnHello(*channel, request.header.source, {now, request.window_bytes});
  const auto found = outboxes.find(request.channel);
  if (request.publisher != source || found == outboxes.end() || found->second->writer == nullptr) return;
  Outbox& outbox = *found->second;
  std::vector<SeqRange> ranges;
  for (const range_t& range : request.ranges) ranges.push_back({range.first, range.last});
  auto answer = outbox.writer->OnRequest(request.header.source, request.delivered, request.window_bytes, ranges, now);
  counts.resent += static_cast<int64_t>(answer.resend.size());
  for (Bytes& message : answer.resend) outgoing_.push_back({outbox.wire_name, std::move(message)});
  if (answer.announce) Announce(outbox);
  acknowledged.notify_all();
}

void Bus::Impl::OnAnnounce(std::string_view wire_name, ByteView bytes, int64_t now) {
  const auto decoded = Decoded<announce_t>(bytes);
  if (!decoded) return;
  const announce_t& announce = *decoded;
  const Channel* channel = FindChannel(announce.channel);
  if (channel == nullptr || !IsAbout(*channel, wire_name, kAnnounce)) return;
  const auto found = inboxes.find(WireName(*channel));
  if (found == inboxes.end() || !found->second.ordered) return;
  Inbox& inbox = found->second;
  OrderedReader* reader = ReaderOf(inbox, announce.header.source, now);
  if (reader == nullptr) return;
  reader->OnAnnounce(announce.first_seq, announce.next_seq, now, announce.join_seq);
  Drain(inbox, *reader, now);
  if (reader->poll_time() > now) return;
  if (const auto request = reader->Poll(now)) Request(inbox, announce.header.source, *request);
}

void Bus::Impl::PollReaders(int64_t now, int64_t& next) {
  for (auto& [name, inbox] : inboxes) {
    if (!inbox.ordered && !inbox.paced) continue;
    if (transport.two_way()) {
      if (now >= inbox.next_hello) {
        inbox.next_hello = now + kHelloPeriod;
        Request(inbox, 0, {});
      }
      next = std::min(next, inbox.next_hello);
    }
    for (auto& [publisher, reader] : inbox.readers) {
      if (reader.poll_time() <= now) {
        if (const auto request = reader.Poll(now)) Request(inbox, publisher, *request);
      }
      if (reader.Front() != nullptr && !Drain(inbox, reader, now)) next = std::min(next, now + kStalledPeriod);
      next = std::min(next, reader.poll_time());
    }
  }
}

void Bus::Impl::PollWriters(int64_t now, int64_t& next) {
  for (auto& [name, outbox] : outboxes) {
    if (outbox->channel.delivery != Delivery::kEvery) continue;
    if (outbox->writer->AnnounceDue(now)) Announce(*outbox);
    next = std::min(next, std::max(outbox->writer->announce_time(), now + kMs));
  }
}

/// "Do you live?" (a question) or "I do": names the other, which is proof enough for it.
void Bus::Impl::Greet(int64_t peer, bool question) {
  repair_request_t message{};
  message.publisher = peer;
  message.delivered = question ? kQuestion : kAnswer;
  // Under the map's prefix, which all listen to who can know of each other.
  SendControl(kRepairRequest, Scope::kMap, message);
}

void Bus::Impl::OnGreeting(int64_t peer, int64_t addressee, int64_t kind) {
  if (addressee == source && kind == kQuestion && authenticator.has_key()) Greet(peer, false);
}

template <class T>
void Bus::Impl::SendControl(const Channel& channel, Scope scope, T message) {
  message.header.schema = kSchemaVersion;
  message.header.source = source;
  message.header.seq = control_seq_[std::string(channel.name)]++;
  std::vector<uint8_t> bytes = Encoded(message);
  const std::string wire_name = std::string(PrefixOf(scope)).append(channel.name);
  authenticator.Append(wire_name, bytes);
  outgoing_.push_back({wire_name, std::make_shared<const std::vector<uint8_t>>(std::move(bytes))});
}

void Bus::Impl::Announce(Outbox& outbox) {
  announce_t announce{};
  announce.channel = outbox.channel.name;
  announce.next_seq = outbox.sent;
  announce.first_seq = std::min(outbox.writer->history().first_seq(), outbox.sent);
  announce.join_seq = std::min(outbox.writer->join_seq(Now()), outbox.sent);
  if (transport.two_way() && outbox.channel.delivery == Delivery::kEvery) {
    SendControl(kAnnounce, outbox.channel.scope, announce);
  }
}

void Bus::Impl::Request(const Inbox& inbox, int64_t publisher, const OrderedReader::Request& request) {
  repair_request_t message{};
  message.channel = inbox.channel.name;
  message.publisher = publisher;
  message.delivered = request.delivered;
  message.window_bytes = static_cast<int32_t>(std::min<int64_t>(transport.receive_window(), 1 << 30));
  for (const SeqRange& range : request.ranges) {
    range_t wire{};
    wire.first = range.first;
    wire.last = range.last;
    message.ranges.push_back(wire);
  }
  message.n_ranges = static_cast<int32_t>(message.ranges.size());
  SendControl(kRepairRequest, inbox.channel.scope, message);
}

void Bus::Impl::SendOutgoing() {
  // Only the receiving thread touches the list, but sending must not hold the mutex: LCM may block.
  std::vector<Outgoing> sending;
  {
    const std::lock_guard lock(mutex);
    sending.swap(outgoing_);
  }
  for (const Outgoing& out : sending) transport.Send(out.wire_name, *out.bytes);
}

}  // namespace plslam::bus
