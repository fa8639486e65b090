// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <chrono>
#include <stdexcept>

#include "core/bus/bus_impl.h"

namespace plslam::bus {
namespace {

/// Publishers remembered for each channel; one that was heard within kRemembered is not forgotten for a new one.
constexpr size_t kMaxSources = 256;

/// The member that has been silent for longest; end() where all were heard lately.
template <class Map>
typename Map::iterator Forgettable(Map& map, int64_t now, int64_t (*heard)(const typename Map::mapped_type&)) {
  const auto oldest = std::min_element(
      map.begin(), map.end(), [&](const auto& a, const auto& b) { return heard(a.second) < heard(b.second); });
  return oldest != map.end() && now - heard(oldest->second) > kRemembered ? oldest : map.end();
}

}  // namespace

int64_t Bus::Impl::Now() {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(std::chrono::steady_clock::now().time_since_epoch())
      .count();
}

void Bus::Impl::Subscribe(const Channel& channel, const char* type, std::shared_ptr<Subscription> subscription) {
  const MessageLayout* layout = FindMessageLayout(type);
  if (channel.type != type || layout == nullptr) {
    throw std::logic_error(std::string(channel.name) + " carries " + std::string(channel.type) + ", not " + type);
  }
  Listen(WireName(channel), channel, layout, subscription);
  const std::string for_map = NameForMap(channel);
  if (channel.scope == Scope::kFromMap && !for_map.empty()) Listen(for_map, channel, layout, subscription);
  transport.Wake();
}

void Bus::Impl::Listen(const std::string& wire_name, const Channel& channel, const MessageLayout* layout,
                       const std::shared_ptr<Subscription>& subscription) {
  bool is_new = false;
  {
    const std::lock_guard lock(mutex);
    Inbox& inbox = inboxes[wire_name];
    is_new = inbox.subscriptions.empty();
    inbox.channel = channel;
    inbox.layout = layout;
    using Kind = Subscription::Kind;
    inbox.ordered |= subscription->kind == Kind::kOrdered || subscription->kind == Kind::kOrderedBytes;
    inbox.paced |= subscription->kind == Kind::kPacedBytes;
    inbox.subscriptions.push_back(subscription);
    next_poll_ = 0;
  }
  if (is_new) transport.Listen(wire_name);
}

void Bus::Impl::MayReceive() {
  may_receive = true;
  may_receive.notify_all();
}

void Bus::Impl::ReceiveLoop() {
  if (transport.kind() == Transport::Kind::kFileRead) may_receive.wait(false);
  while (!stopping_) {
    const int64_t now = Now();
    int64_t next = now + 100 * kMs;
    {
      const std::lock_guard lock(mutex);
      PollReaders(now, next);
      PollWriters(now, next);
      next_poll_ = next;
      wake_time_ = next;
    }
    SendOutgoing();
    const int64_t wait = std::max<int64_t>(0, next - Now());
    if (!transport.Receive(static_cast<int>((wait + kMs - 1) / kMs))) EndReaders();
  }
}

/// What a log does not have by its end never comes.
void Bus::Impl::EndReaders() {
  const std::lock_guard lock(mutex);
  for (auto& [name, inbox] : inboxes) {
    for (auto& [publisher, reader] : inbox.readers) reader.OnEnd();
  }
}

bool Bus::Impl::Drop() {
  if (options.drop_fraction <= 0.0) return false;
  return static_cast<double>(drop_random_() >> 11) * 0x1p-53 < options.drop_fraction;
}

void Bus::Impl::OnDatagram(std::string_view wire_name, ByteView bytes) {
  const int64_t now = Now();
  {
    const std::lock_guard lock(mutex);
    if (Drop()) return;
    NoticePrefix(wire_name, now);
    const bool is_request = IsNamed(wire_name, kRepairRequest);
    const bool is_announce = !is_request && IsNamed(wire_name, kAnnounce);
    const auto inbox = inboxes.find(wire_name);
    if (rest && inbox == inboxes.end()) rest(wire_name, bytes);
    if (!is_request && !is_announce && inbox == inboxes.end()) return;
    const MessageLayout* layout = is_request    ? request_layout_
                                  : is_announce ? announce_layout_
                                                : inbox->second.layout;
    const ByteView message = Checked(wire_name, *layout, bytes, now);
    if (message.empty()) return;
    ++counts.received;
    if (Lives(wire_name, message, now)) {
      if (is_request) OnRepairRequest(wire_name, message, now);
      if (is_announce) OnAnnounce(wire_name, message, now);
      if (inbox != inboxes.end()) Dispatch(inbox->second, ReadHeader(message), message, now);
    }
  }
  SendOutgoing();
}

void Bus::Impl::Dispatch(Inbox& inbox, const WireHeader& header, ByteView message, int64_t now) {
  for (const auto& subscription : inbox.subscriptions) {
    using Kind = Subscription::Kind;
    const bool now_or_never = subscription->kind == Kind::kBytes || subscription->kind == Kind::kPacedBytes;
    if (now_or_never) subscription->deliver(message);
  }
  if (inbox.paced) DispatchPaced(inbox, header, message);
  if (inbox.ordered) DispatchOrdered(inbox, header, message, now);
  DispatchLatest(inbox, header, message, now);
}

void Bus::Impl::DispatchPaced(Inbox& inbox, const WireHeader& header, ByteView message) {
  static constexpr int64_t kAcknowledgedCost = 28'000;
  if (!inbox.unacknowledged.contains(header.source) && inbox.unacknowledged.size() >= kMaxSources) {
    inbox.unacknowledged.clear();
  }
  int64_t& cost = inbox.unacknowledged[header.source];
  cost += WireCost(message.size());
  if (cost < kAcknowledgedCost) return;
  cost = 0;
  Request(inbox, header.source, {header.seq, {}});
}

OrderedReader* Bus::Impl::ReaderOf(Inbox& inbox, int64_t publisher, int64_t now) {
  const auto found = inbox.readers.find(publisher);
  if (found != inbox.readers.end()) return &found->second;
  if (inbox.readers.size() >= kMaxSources) {
    const auto old = Forgettable(
        inbox.readers, now, +[](const OrderedReader& r) { return r.heard(); });
    if (old == inbox.readers.end()) return nullptr;
    given_lost += old->second.lost();
    given_repaired += old->second.repaired();
    inbox.readers.erase(old);
  }
  OrderedReader reader(transport.two_way(), options.queue_bytes, now, static_cast<int64_t>(options.give_up_s * 1e9));
  return &inbox.readers.emplace(publisher, std::move(reader)).first->second;
}

void Bus::Impl::DispatchOrdered(Inbox& inbox, const WireHeader& header, ByteView message, int64_t now) {
  OrderedReader* reader = ReaderOf(inbox, header.source, now);
  if (reader == nullptr) {
    ++counts.rejected;
    return;
  }
  const auto arrival = reader->OnMessage(header.seq, message, now);
  if (arrival == OrderedReader::Arrival::kDuplicate) ++counts.duplicates;
  Drain(inbox, *reader, now);
  if (reader->poll_time() > now) return;
  if (const auto request = reader->Poll(now)) Request(inbox, header.source, *request);
}

bool Bus::Impl::Ready(const Inbox& inbox) const {
  return takes_more && loop.queued_bytes() < options.queue_bytes &&
         std::all_of(inbox.subscriptions.begin(), inbox.subscriptions.end(),
                     [](const auto& s) { return s->kind != Subscription::Kind::kOrderedBytes || s->ready(); });
}

/// Delivers what is in order; false where handlers are too far behind to take it.
bool Bus::Impl::Drain(Inbox& inbox, OrderedReader& reader, int64_t now) {
  while (Bytes message = reader.Front()) {
    if (!Ready(inbox)) return false;
    for (const auto& subscription : inbox.subscriptions) {
      if (subscription->kind == Subscription::Kind::kOrdered) Deliver(subscription, message);
      if (subscription->kind == Subscription::Kind::kOrderedBytes) subscription->deliver(*message);
    }
    reader.Pop(now);
  }
  return true;
}

void Bus::Impl::Deliver(const std::shared_ptr<Subscription>& subscription, Bytes message) {
  const auto size = static_cast<int64_t>(message->size());
  loop.Post([subscription, message = std::move(message)] { subscription->deliver(*message); }, size);
}

void Bus::Impl::DispatchLatest(Inbox& inbox, const WireHeader& header, ByteView message, int64_t now) {
  using Kind = Subscription::Kind;
  const auto wants = [](const auto& s) { return s->kind == Kind::kNewest || s->kind == Kind::kAsItComes; };
  if (std::none_of(inbox.subscriptions.begin(), inbox.subscriptions.end(), wants)) return;
  if (!inbox.latest.contains(header.source) && inbox.latest.size() >= kMaxSources) {
    const auto old = Forgettable(
        inbox.latest, now, +[](const Inbox::Latest& l) { return l.heard; });
    if (old == inbox.latest.end()) {
      ++counts.rejected;
      return;
    }
    inbox.latest.erase(old);
  }
  Inbox::Latest& latest = inbox.latest[header.source];
  latest.heard = now;
  if (header.seq <= latest.seq) {
    counts.duplicates += inbox.ordered ? 0 : 1;
    return;
  }
  latest.seq = header.seq;
  const auto shared = std::make_shared<const std::vector<uint8_t>>(message.begin(), message.end());
  latest.slots.resize(inbox.subscriptions.size());
  for (size_t i = 0; i < inbox.subscriptions.size(); ++i) {
    const auto& subscription = inbox.subscriptions[i];
    if (subscription->kind == Kind::kNewest) PostNewest(latest, i, subscription, shared);
    if (subscription->kind == Kind::kAsItComes && loop.queued_bytes() < options.queue_bytes) {
      Deliver(subscription, shared);
    }
  }
}

void Bus::Impl::PostNewest(Inbox::Latest& latest, size_t subscription, const std::shared_ptr<Subscription>& s,
                           Bytes message) {
  std::shared_ptr<LatestSlot>& slot = latest.slots[subscription];
  if (slot == nullptr) slot = std::make_shared<LatestSlot>();
  Bytes overtaken;
  {
    const std::lock_guard lock(slot->mutex);
    overtaken = std::exchange(slot->newest, std::move(message));
  }
  if (overtaken != nullptr) {
    ++counts.skipped;
    return;  // the task that waits takes the newer one
  }
  loop.Post([slot, s] {
    Bytes newest;
    {
      const std::lock_guard lock(slot->mutex);
      newest = std::exchange(slot->newest, nullptr);
    }
    s->deliver(*newest);
  });
}

}  // namespace plslam::bus
