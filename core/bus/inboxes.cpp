// SPDX-License-Identifier: BSD-3-Clause
#include "core/bus/inboxes.h"

#include <algorithm>
#include <utility>

#include "core/bus/outboxes.h"

namespace plslam::bus {
namespace {

/// Number of remembered publishers for each channel; one that was heard recently is not replaced by a new one.
constexpr size_t kMaxSources = 256;
constexpr int64_t kHelloPeriod_ns = 300 * kMs;
/// Interval at which a reader checks again whether its handlers have caught up.
constexpr int64_t kStalledPeriod_ns = 2 * kMs;

/// Returns the member that has been silent for longest; end() if all were heard recently.
template <class Map, class Heard>
typename Map::iterator Forgettable(Map& map, int64_t now, const Heard& heard) {
  const auto oldest = std::min_element(
      map.begin(), map.end(), [&](const auto& a, const auto& b) { return heard(a.second) < heard(b.second); });
  return oldest != map.end() && now - heard(oldest->second) > Outboxes::kRemembered_ns ? oldest : map.end();
}

}  // namespace

Inboxes::Inboxes(const BusOptions& options, bool two_way, RunLoop& loop, ReceiverCounts& counts, Ask ask)
    : options_(options), two_way_(two_way), loop_(loop), counts_(counts), ask_(std::move(ask)) {}

void Inboxes::Add(const std::string& wire_name, const Channel& channel, const MessageLayout* layout,
                  std::shared_ptr<Subscription> subscription) {
  const std::lock_guard lock(orders_mutex_);
  additions_.push_back({wire_name, channel, layout, std::move(subscription)});
  has_orders_ = true;
}

void Inboxes::AddRest(Rest rest) {
  const std::lock_guard lock(orders_mutex_);
  added_rest_ = std::move(rest);
  has_orders_ = true;
}

void Inboxes::Close(std::function<void()> then) {
  const std::lock_guard lock(orders_mutex_);
  when_closed_ = std::move(then);
  has_orders_ = true;
}

void Inboxes::TakeOrders() {
  if (!has_orders_) return;
  std::vector<Addition> additions;
  Rest rest;
  std::function<void()> when_closed;
  {
    const std::lock_guard lock(orders_mutex_);
    has_orders_ = false;
    additions.swap(additions_);
    rest = std::exchange(added_rest_, nullptr);
    when_closed = std::exchange(when_closed_, nullptr);
  }
  for (Addition& addition : additions) {
    Inbox& inbox = inboxes_[addition.wire_name];
    inbox.channel = addition.channel;
    inbox.layout = addition.layout;
    using Kind = Subscription::Kind;
    const Kind kind = addition.subscription->kind;
    inbox.ordered |= kind == Kind::kOrdered || kind == Kind::kOrderedBytes;
    inbox.paced |= kind == Kind::kPacedBytes;
    inbox.subscriptions.push_back(std::move(addition.subscription));
  }
  if (rest) rest_ = std::move(rest);
  if (when_closed) {
    takes_more_ = false;
    when_closed();
  }
}

const MessageLayout* Inboxes::LayoutOf(std::string_view wire_name) {
  TakeOrders();
  const auto found = inboxes_.find(wire_name);
  return found == inboxes_.end() ? nullptr : found->second.layout;
}

void Inboxes::TakeRest(std::string_view wire_name, ByteView bytes) const {
  if (rest_) rest_(wire_name, bytes);
}

void Inboxes::Dispatch(std::string_view wire_name, const WireHeader& header, ByteView message, int64_t now) {
  const auto found = inboxes_.find(wire_name);
  if (found == inboxes_.end()) return;
  Inbox& inbox = found->second;
  for (const auto& subscription : inbox.subscriptions) {
    using Kind = Subscription::Kind;
    const bool now_or_never = subscription->kind == Kind::kBytes || subscription->kind == Kind::kPacedBytes;
    if (now_or_never) subscription->deliver(message);
  }
  if (inbox.paced) DispatchPaced(inbox, header, message);
  if (inbox.ordered) DispatchOrdered(inbox, header, message, now);
  DispatchLatest(inbox, header, message, now);
}

void Inboxes::DispatchPaced(Inbox& inbox, const WireHeader& header, ByteView message) {
  const SourceId publisher = header.source;
  static constexpr int64_t kAcknowledgedCost = 28'000;
  if (!inbox.unacknowledged.contains(publisher) && inbox.unacknowledged.size() >= kMaxSources) {
    inbox.unacknowledged.clear();
  }
  int64_t& cost = inbox.unacknowledged[publisher];
  cost += WireCost(message.size());
  if (cost < kAcknowledgedCost) return;
  cost = 0;
  ask_(inbox.channel, publisher, {header.seq, {}});
}

Inboxes::Source* Inboxes::SourceOf(Inbox& inbox, SourceId publisher, int64_t now) {
  const auto found = inbox.sources.find(publisher);
  if (found != inbox.sources.end()) return &found->second;
  if (inbox.sources.size() >= kMaxSources) {
    const auto old = Forgettable(inbox.sources, now, [](const Source& source) { return source.reader.heard(); });
    if (old == inbox.sources.end()) return nullptr;
    inbox.sources.erase(old);
  }
  OrderedReader reader(two_way_, options_.queue_bytes, now, static_cast<int64_t>(options_.give_up_s * 1e9));
  return &inbox.sources.emplace(publisher, Source{std::move(reader)}).first->second;
}

/// Adds the reader's counts since the last call.
void Inboxes::Count(const Inbox& inbox, Source& source) {
  counts_.AddLost(inbox.channel.name, source.reader.lost() - std::exchange(source.lost, source.reader.lost()));
  counts_.repaired += source.reader.repaired() - std::exchange(source.repaired, source.reader.repaired());
}

void Inboxes::PollSource(const Inbox& inbox, SourceId publisher, Source& source, int64_t now) {
  if (source.reader.poll_time() <= now) {
    if (const auto request = source.reader.Poll(now)) ask_(inbox.channel, publisher, *request);
  }
  Count(inbox, source);
}

void Inboxes::DispatchOrdered(Inbox& inbox, const WireHeader& header, ByteView message, int64_t now) {
  const SourceId publisher = header.source;
  Source* source = SourceOf(inbox, publisher, now);
  if (source == nullptr) {
    ++counts_.rejected;
    return;
  }
  const auto arrival = source->reader.OnMessage(header.seq, message, now);
  if (arrival == OrderedReader::Arrival::kDuplicate) ++counts_.duplicates;
  Count(inbox, *source);  // before the handler: it may compare the counts with what it has received
  Drain(inbox, *source, now);
  PollSource(inbox, publisher, *source, now);
}

bool Inboxes::Ready(const Inbox& inbox) const {
  return takes_more_ && loop_.queued_bytes() < options_.queue_bytes &&
         std::all_of(inbox.subscriptions.begin(), inbox.subscriptions.end(),
                     [](const auto& s) { return s->kind != Subscription::Kind::kOrderedBytes || s->ready(); });
}

/// Delivers the messages in order; returns false if handlers are too slow to take them.
bool Inboxes::Drain(Inbox& inbox, Source& source, int64_t now) {
  while (Bytes message = source.reader.Front()) {
    if (!Ready(inbox)) return false;
    for (const auto& subscription : inbox.subscriptions) {
      if (subscription->kind == Subscription::Kind::kOrdered) Post(subscription, message);
      if (subscription->kind == Subscription::Kind::kOrderedBytes) subscription->deliver(*message);
    }
    source.reader.Pop(now);
  }
  return true;
}

void Inboxes::Post(const std::shared_ptr<Subscription>& subscription, Bytes message) {
  const auto size = static_cast<int64_t>(message->size());
  loop_.Post([subscription, message = std::move(message)] { subscription->deliver(*message); }, size);
}

void Inboxes::DispatchLatest(Inbox& inbox, const WireHeader& header, ByteView message, int64_t now) {
  using Kind = Subscription::Kind;
  const auto wants = [](const auto& s) { return s->kind == Kind::kNewest || s->kind == Kind::kAsItComes; };
  if (std::none_of(inbox.subscriptions.begin(), inbox.subscriptions.end(), wants)) return;
  const SourceId publisher = header.source;
  if (!inbox.latest.contains(publisher) && inbox.latest.size() >= kMaxSources) {
    const auto old = Forgettable(inbox.latest, now, [](const Latest& l) { return l.heard; });
    if (old == inbox.latest.end()) {
      ++counts_.rejected;
      return;
    }
    inbox.latest.erase(old);
  }
  Latest& latest = inbox.latest[publisher];
  latest.heard = now;
  if (header.seq <= latest.seq) {
    counts_.duplicates += inbox.ordered ? 0 : 1;
    return;
  }
  latest.seq = header.seq;
  const auto shared = std::make_shared<const std::vector<uint8_t>>(message.begin(), message.end());
  latest.slots.resize(inbox.subscriptions.size());
  for (size_t i = 0; i < inbox.subscriptions.size(); ++i) {
    const auto& subscription = inbox.subscriptions[i];
    if (subscription->kind == Kind::kNewest) PostNewest(latest, i, subscription, shared);
    if (subscription->kind == Kind::kAsItComes && loop_.queued_bytes() < options_.queue_bytes) {
      Post(subscription, shared);
    }
  }
}

void Inboxes::PostNewest(Latest& latest, size_t subscription, const std::shared_ptr<Subscription>& s, Bytes message) {
  std::shared_ptr<LatestSlot>& slot = latest.slots[subscription];
  if (slot == nullptr) slot = std::make_shared<LatestSlot>();
  Bytes overtaken;
  {
    const std::lock_guard lock(slot->mutex);
    overtaken = std::exchange(slot->newest, std::move(message));
  }
  if (overtaken != nullptr) {
    ++counts_.skipped;
    return;  // the task that waits takes the newer one
  }
  loop_.Post([slot, s] {
    Bytes newest;
    {
      const std::lock_guard lock(slot->mutex);
      newest = std::exchange(slot->newest, nullptr);
    }
    s->deliver(*newest);
  });
}

void Inboxes::OnAnnounce(std::string_view wire_name, SourceId publisher, int64_t first_seq, int64_t next_seq,
                         int64_t join_seq, int64_t now) {
  const auto found = inboxes_.find(wire_name);
  if (found == inboxes_.end() || !found->second.ordered) return;
  Inbox& inbox = found->second;
  Source* source = SourceOf(inbox, publisher, now);
  if (source == nullptr) return;
  source->reader.OnAnnounce(first_seq, next_seq, now, join_seq);
  Drain(inbox, *source, now);
  PollSource(inbox, publisher, *source, now);
}

void Inboxes::Poll(int64_t now, int64_t& next) {
  TakeOrders();
  for (auto& [name, inbox] : inboxes_) {
    if (!inbox.ordered && !inbox.paced) continue;
    if (two_way_) {
      if (now >= inbox.next_hello) {
        inbox.next_hello = now + kHelloPeriod_ns;
        ask_(inbox.channel, 0, {});
      }
      next = std::min(next, inbox.next_hello);
    }
    for (auto& [publisher, source] : inbox.sources) {
      PollSource(inbox, publisher, source, now);
      if (source.reader.Front() != nullptr && !Drain(inbox, source, now))
        next = std::min(next, now + kStalledPeriod_ns);
      next = std::min(next, source.reader.poll_time());
    }
  }
}

void Inboxes::OnEnd() {
  for (auto& [name, inbox] : inboxes_) {
    for (auto& [publisher, source] : inbox.sources) source.reader.OnEnd();
  }
}

}  // namespace plslam::bus
