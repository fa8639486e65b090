// SPDX-License-Identifier: BSD-3-Clause
#include "core/bus/delivery/ordered_reader.h"

#include <algorithm>
#include <utility>

namespace plslam::bus {
namespace {

/// Largest number of missing messages requested at a time, and of ranges in one request.
constexpr int64_t kMaxAsked = 64;
constexpr size_t kMaxRanges = 32;
/// A larger jump of the numbers is forged or a fault.
constexpr int64_t kMaxJump = 50'000'000;
/// Large messages are acknowledged one by one, since the window holds few of them.
constexpr int64_t kPromptAckCost = 28'000;
/// Without repair: number of messages after a gap until it is given up.
constexpr size_t kOneWayPatience = 256;

}  // namespace

OrderedReader::OrderedReader(bool two_way, int64_t buffer_bytes, int64_t now, int64_t silent_ns)
    : two_way_(two_way), buffer_limit_(buffer_bytes), heard_(now), progress_(now), kept_(now - times_.absent_ns) {
  times_.silent_ns = silent_ns;
  retry_pause_ = times_.retry_first_ns;
}

void OrderedReader::Heard(int64_t now) {
  if (now - heard_ > times_.absent_ns) progress_ = now;
  heard_ = now;
}

OrderedReader::Arrival OrderedReader::OnMessage(int64_t seq, ByteView bytes, int64_t now) {
  Heard(now);
  if (seq > kMaxNumber || (known_end_ > 0 && seq > known_end_ + kMaxJump)) return Arrival::kRefused;
  if (known_end_ == 0 && !started_) {
    join_end_ = seq;
    if (seq == 0 || !two_way_) Start(seq, now);
    known_end_ = seq;
  }
  if ((started_ && seq < expected_) || buffer_.contains(seq)) return Arrival::kDuplicate;
  if (buffered_bytes_ + static_cast<int64_t>(bytes.size()) > buffer_limit_ && seq != expected_) {
    return Arrival::kRefused;  // requested again when there is room
  }
  if (seq < known_end_) {
    if (seq >= join_end_ && seq < counted_end_) ++repaired_;
    progress_ = now;
    progressed_ = fresh_ = true;
  } else {
    if (!HasGap()) progress_ = now;
    fresh_ = fresh_ || seq > known_end_;
    known_end_ = seq + 1;
  }
  buffer_.emplace(seq, std::make_shared<const std::vector<uint8_t>>(bytes.begin(), bytes.end()));
  buffered_bytes_ += static_cast<int64_t>(bytes.size());
  Schedule();
  return Arrival::kNew;
}

void OrderedReader::OnAnnounce(int64_t first_seq, int64_t next_seq, int64_t now, std::optional<int64_t> join_seq) {
  if (first_seq < 0 || next_seq < first_seq || next_seq > kMaxNumber) return;
  if (next_seq > std::max(known_end_, first_seq) + kMaxJump) return;
  Heard(now);
  if (!started_) {
    if (known_end_ == 0) join_end_ = next_seq;
    // Buffered messages may be older: the publisher has dropped the messages that all other readers have.
    const int64_t begin = std::clamp(join_seq.value_or(first_seq), first_seq, next_seq);
    Start(buffer_.empty() ? begin : std::min(begin, buffer_.begin()->first), now);
  }
  if (next_seq > known_end_) {
    if (!HasGap()) progress_ = now;
    known_end_ = next_seq;
    fresh_ = true;
  }
  if (expected_ < first_seq) {
    SkipTo(first_seq);
  } else {
    kept_ = now;
  }
  if (expected_ >= next_seq) ack_at_ = std::min(ack_at_, last_ack_ + times_.ack_pause_ns);
  // An announcement also ends a batch of resent messages: the rest may be requested.
  if (progressed_) ask_now_ = true;
  Schedule();
}

void OrderedReader::Start(int64_t first, int64_t now) {
  started_ = true;
  expected_ = first;
  asked_end_ = first;
  progress_ = now;
  ack_at_ = std::min(ack_at_, now);
}

void OrderedReader::CountAsked(const std::vector<SeqRange>& ranges) {
  for (const SeqRange& range : ranges) {
    lost_ += std::max<int64_t>(0, range.last + 1 - std::max({range.first, join_end_, counted_end_}));
    counted_end_ = std::max(counted_end_, range.last + 1);
  }
}

/// Gives up the missing messages before `seq`; buffered ones are still delivered in order. Messages sent before this
/// reader joined (below `join_end_`) are counted as lost only here.
void OrderedReader::SkipTo(int64_t seq) {
  while (expected_ < seq) {
    if (!buffer_.empty() && buffer_.begin()->first == expected_) return;  // deliver it first; called again later
    const int64_t next = buffer_.empty() ? seq : std::min(seq, buffer_.begin()->first);
    lost_ +=
        std::max<int64_t>(0, two_way_ ? std::min({next, join_end_, counted_end_}) - expected_ : next - expected_);
    expected_ = next;
  }
  asked_end_ = std::max(asked_end_, expected_);
}

Bytes OrderedReader::Front() const {
  if (!started_ || buffer_.empty() || buffer_.begin()->first != expected_) return nullptr;
  return buffer_.begin()->second;
}

void OrderedReader::Pop(int64_t now) {
  const auto front = buffer_.begin();
  const auto size = front->second->size();
  buffered_bytes_ -= static_cast<int64_t>(size);
  buffer_.erase(front);
  ++expected_;
  unacked_cost_ += WireCost(size);
  if (unacked_cost_ >= kPromptAckCost) ack_at_ = now;
  ack_at_ = std::min(ack_at_, std::max(now, last_ack_ + times_.ack_pause_ns));
  Schedule();
}

std::vector<SeqRange> OrderedReader::Missing(int64_t from, int64_t to, int64_t budget) const {
  std::vector<SeqRange> ranges;
  auto next = buffer_.lower_bound(from);
  for (int64_t seq = from; seq < to && budget > 0 && ranges.size() < kMaxRanges;) {
    const int64_t end = next == buffer_.end() ? to : std::min(to, next->first);
    if (seq < end) {
      ranges.push_back({seq, std::min(end, seq + budget) - 1});
      budget -= ranges.back().last - seq + 1;
    }
    if (next == buffer_.end()) break;
    seq = next->first + 1;
    ++next;
  }
  return ranges;
}

namespace {

int64_t Count(const std::vector<SeqRange>& ranges) {
  int64_t count = 0;
  for (const SeqRange& range : ranges) count += range.last - range.first + 1;
  return count;
}

}  // namespace

/// Returns the ranges to request: everything missing, if the last request has been answered or has timed out; otherwise
/// only gaps that were not requested yet.
std::optional<std::vector<SeqRange>> OrderedReader::Asking(int64_t now) {
  if (!two_way_ || !HasGap()) {
    retry_at_ = kFar;
    retry_pause_ = times_.retry_first_ns;
    return std::nullopt;
  }
  if (!started_) {  // the first number is unknown: the publisher answers an empty request with an announcement
    if (retry_at_ != kFar && now < retry_at_) return std::nullopt;
    retry_at_ = now + retry_pause_;
    retry_pause_ = std::min(2 * retry_pause_, times_.retry_max_ns);
    return std::vector<SeqRange>();
  }
  asked_end_ = std::max(asked_end_, expected_);
  if (ask_now_ || now >= retry_at_) {
    if (progressed_) retry_pause_ = times_.retry_first_ns;
    auto ranges = Missing(expected_, known_end_, kMaxAsked);
    CountAsked(ranges);
    asked_end_ = ranges.empty() ? asked_end_ : ranges.back().last + 1;
    retry_at_ = now + retry_pause_;
    retry_pause_ = std::min(2 * retry_pause_, times_.retry_max_ns);
    progressed_ = ask_now_ = fresh_ = false;
    return ranges;
  }
  const int64_t asked = Count(Missing(expected_, asked_end_, kMaxAsked));
  if (asked > kMaxAsked / 2) return std::nullopt;  // catching up: by batches, not one by one
  const int64_t budget = kMaxAsked - asked;
  auto fresh = Missing(asked_end_, known_end_, budget);
  fresh_ = false;
  if (fresh.empty()) return std::nullopt;
  CountAsked(fresh);
  asked_end_ = fresh.back().last + 1;
  if (retry_at_ == kFar) {
    retry_at_ = now + retry_pause_;
    retry_pause_ = std::min(2 * retry_pause_, times_.retry_max_ns);
  }
  return fresh;
}

std::optional<OrderedReader::Request> OrderedReader::Poll(int64_t now) {
  if (HasGap()) GiveUp(now);
  auto ranges = Asking(now);
  std::optional<Request> request;
  if (ranges || (two_way_ && now >= ack_at_)) {
    request = Request{started_ ? expected_ - 1 : -1, ranges.value_or(std::vector<SeqRange>())};
    last_ack_ = now;
    unacked_cost_ = 0;
    ack_at_ = kFar;
  }
  Schedule();
  if (poll_time_ <= now && !request) poll_time_ = now + times_.ack_pause_ns;
  return request;
}

void OrderedReader::GiveUp(int64_t now) {
  if (Front() != nullptr) return;  // the reader's own queue is full: no message is missing
  const bool exited = now - heard_ > times_.silent_ns && now - progress_ > times_.silent_ns;
  const bool hopeless = now - heard_ <= times_.absent_ns && now - progress_ > Patience(now);
  if (!exited && !hopeless && !IsOneWayGap()) return;
  if (!started_) {
    if (buffer_.empty()) return;
    Start(buffer_.begin()->first, now);
    if (exited) progress_ = heard_;  // nor for its other gaps
    return;
  }
  SkipTo(buffer_.empty() ? known_end_ : buffer_.begin()->first);
  if (!exited) progress_ = now;  // the other gaps of an exited publisher need no separate wait
}

/// Returns how long to wait for a gap of a publisher whose messages arrive. If large messages hardly get through, more
/// requests help as long as the publisher has the messages.
int64_t OrderedReader::Patience(int64_t now) const {
  return now - kept_ < times_.absent_ns ? times_.kept_ns : times_.hopeless_ns;
}

bool OrderedReader::IsOneWayGap() const { return !two_way_ && (ended_ || buffer_.size() > kOneWayPatience); }

void OrderedReader::OnEnd() {
  ended_ = true;
  Schedule();
}

/// Returns the time when `GiveUp` becomes due if no message arrives until then.
int64_t OrderedReader::GiveUpTime() const {
  const int64_t exited = std::max(heard_, progress_) + times_.silent_ns + 1;
  // The earliest time that exceeds its `Patience`.
  const int64_t hopeless = std::min(progress_ + times_.kept_ns + 1,
                                    std::max(progress_ + times_.hopeless_ns + 1, kept_ + times_.absent_ns));
  return hopeless - heard_ <= times_.absent_ns ? std::min(exited, hopeless) : exited;
}

void OrderedReader::Schedule() {
  poll_time_ = two_way_ ? ack_at_ : kFar;
  if (!HasGap()) return;
  const bool at_once = two_way_ ? ask_now_ || fresh_ || retry_at_ == kFar : IsOneWayGap();
  poll_time_ = at_once ? 0 : std::min({poll_time_, retry_at_, GiveUpTime()});
}

}  // namespace plslam::bus
