// SPDX-License-Identifier: BSD-3-Clause
#include "core/bus/delivery/ordered_reader.h"

#include <algorithm>
#include <utility>

namespace plslam::bus {
namespace {

/// A larger jump of the numbers is forged or a fault.
constexpr int64_t kMaxJump = 50'000'000;
/// Without repair: number of messages after a gap until it is given up.
constexpr int64_t kOneWayPatience = 256;

ReaderTimes TimesWith(int64_t silent_ns) {
  ReaderTimes times;
  times.silent_ns = silent_ns;
  return times;
}

}  // namespace

OrderedReader::OrderedReader(bool two_way, int64_t buffer_bytes, int64_t now, int64_t silent_ns)
    : two_way_(two_way),
      early_(buffer_bytes),
      acks_(ReaderTimes{}.ack_pause_ns),
      patience_(TimesWith(silent_ns), now),
      requests_(ReaderTimes{}) {}

OrderedReader::Arrival OrderedReader::OnMessage(int64_t seq, ByteView bytes, int64_t now) {
  patience_.Heard(now);
  if (seq > kMaxNumber || (known_end_ > 0 && seq > known_end_ + kMaxJump)) return Arrival::kRefused;
  if (known_end_ == 0 && state_ == State::kUnknown) {
    losses_.Join(seq);
    if (seq == 0 || !two_way_) Start(seq, now);
    known_end_ = seq;
  }
  if ((state_ != State::kUnknown && seq < expected_) || early_.Contains(seq)) return Arrival::kDuplicate;
  // Requested again when there is room.
  if (!early_.HasRoomFor(bytes.size()) && seq != expected_) return Arrival::kRefused;
  if (seq < known_end_) {
    losses_.AddArrived(seq);
    patience_.Progress(now);
    requests_.OnArrival();
  } else {
    if (!HasGap()) patience_.Progress(now);
    if (seq > known_end_) requests_.OnGap();
    known_end_ = seq + 1;
  }
  early_.Add(seq, bytes);
  Schedule();
  return Arrival::kNew;
}

void OrderedReader::OnAnnounce(int64_t first_seq, int64_t next_seq, int64_t now, std::optional<int64_t> join_seq) {
  if (first_seq < 0 || next_seq < first_seq || next_seq > kMaxNumber) return;
  if (next_seq > std::max(known_end_, first_seq) + kMaxJump) return;
  patience_.Heard(now);
  if (state_ == State::kUnknown) {
    if (known_end_ == 0) losses_.Join(next_seq);
    // Buffered messages may be older: the publisher has dropped the messages that all other readers have.
    const int64_t begin = std::clamp(join_seq.value_or(first_seq), first_seq, next_seq);
    Start(early_.empty() ? begin : std::min(begin, early_.first_seq()), now);
  }
  if (next_seq > known_end_) {
    if (!HasGap()) patience_.Progress(now);
    known_end_ = next_seq;
    requests_.OnGap();
  }
  if (expected_ < first_seq) {
    SkipTo(first_seq);
  } else {
    patience_.Kept(now);
  }
  if (expected_ >= next_seq) acks_.RequireAfterPause();
  requests_.OnAnnounce();
  Schedule();
}

void OrderedReader::Start(int64_t first, int64_t now) {
  state_ = State::kOpen;
  expected_ = first;
  requests_.Begin(first);
  patience_.Progress(now);
  acks_.Require(now);
}

/// Gives up the missing messages before `seq`; buffered ones are still delivered in order.
void OrderedReader::SkipTo(int64_t seq) {
  while (expected_ < seq) {
    if (!early_.empty() && early_.first_seq() == expected_) return;  // deliver it first; called again later
    const int64_t next = early_.empty() ? seq : std::min(seq, early_.first_seq());
    losses_.AddGivenUp(expected_, next, two_way_);
    expected_ = next;
  }
  requests_.SkipTo(expected_);
}

Bytes OrderedReader::Front() const {
  const bool is_next = state_ != State::kUnknown && !early_.empty() && early_.first_seq() == expected_;
  return is_next ? early_.first() : nullptr;
}

void OrderedReader::Pop(int64_t now) {
  acks_.OnDelivered(early_.Pop(), now);
  ++expected_;
  Schedule();
}

/// Returns the ranges to request; an empty list asks for the first number.
std::optional<std::vector<SeqRange>> OrderedReader::TakeRanges(int64_t now) {
  if (!two_way_ || !HasGap()) {
    requests_.Rest();
    return std::nullopt;
  }
  if (state_ == State::kUnknown) {
    return requests_.TakeHello(now) ? std::optional(std::vector<SeqRange>()) : std::nullopt;
  }
  auto ranges = requests_.Take(early_, expected_, known_end_, now);
  if (ranges) losses_.AddRequested(*ranges);
  return ranges;
}

std::optional<OrderedReader::Request> OrderedReader::Poll(int64_t now) {
  if (HasGap()) GiveUp(now);
  auto ranges = TakeRanges(now);
  std::optional<Request> request;
  if (ranges || (two_way_ && now >= acks_.time())) {
    const int64_t delivered = state_ == State::kUnknown ? -1 : expected_ - 1;
    request = Request{delivered, ranges.value_or(std::vector<SeqRange>())};
    acks_.OnSent(now);
  }
  Schedule();
  if (poll_time_ <= now && !request) poll_time_ = now + acks_.pause_ns();
  return request;
}

void OrderedReader::GiveUp(int64_t now) {
  if (Front() != nullptr) return;  // the reader's own queue is full: no message is missing
  const bool exited = patience_.HasExited(now);
  if (!exited && !patience_.IsHopeless(now) && !IsOneWayGap()) return;
  if (state_ == State::kUnknown) {
    if (early_.empty()) return;
    Start(early_.first_seq(), now);
    if (exited) patience_.Progress(patience_.heard());  // nor for its other gaps
    return;
  }
  SkipTo(early_.empty() ? known_end_ : early_.first_seq());
  if (!exited) patience_.Progress(now);  // the other gaps of an exited publisher need no separate wait
}

bool OrderedReader::IsOneWayGap() const {
  return !two_way_ && (state_ == State::kEnded || early_.size() > kOneWayPatience);
}

void OrderedReader::OnEnd() {
  if (state_ == State::kOpen) state_ = State::kEnded;
  Schedule();
}

void OrderedReader::Schedule() {
  poll_time_ = two_way_ ? acks_.time() : INT64_MAX;
  if (!HasGap()) return;
  const bool at_once = two_way_ ? requests_.IsDueAtOnce() : IsOneWayGap();
  poll_time_ = at_once ? 0 : std::min({poll_time_, requests_.retry_time(), patience_.EndTime()});
}

}  // namespace plslam::bus
