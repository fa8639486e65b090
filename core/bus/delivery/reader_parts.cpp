// SPDX-License-Identifier: BSD-3-Clause
#include "core/bus/delivery/reader_parts.h"

#include <algorithm>
#include <memory>

namespace plslam::bus {
namespace {

/// Largest number of missing messages requested at a time, and of ranges in one request.
constexpr int64_t kMaxAsked = 64;
constexpr size_t kMaxRanges = 32;
/// Messages of this cost are acknowledged at once.
constexpr int64_t kPromptAckCost = 28'000;

int64_t Count(const std::vector<SeqRange>& ranges) {
  int64_t count = 0;
  for (const SeqRange& range : ranges) count += range.last - range.first + 1;
  return count;
}

}  // namespace

void EarlyMessages::Add(int64_t seq, ByteView bytes) {
  messages_.emplace(seq, std::make_shared<const std::vector<uint8_t>>(bytes.begin(), bytes.end()));
  bytes_ += static_cast<int64_t>(bytes.size());
}

size_t EarlyMessages::Pop() {
  const auto front = messages_.begin();
  const auto size = front->second->size();
  bytes_ -= static_cast<int64_t>(size);
  messages_.erase(front);
  return size;
}

std::vector<SeqRange> EarlyMessages::Missing(int64_t from, int64_t to, int64_t budget) const {
  std::vector<SeqRange> ranges;
  auto next = messages_.lower_bound(from);
  for (int64_t seq = from; seq < to && budget > 0 && ranges.size() < kMaxRanges;) {
    const int64_t end = next == messages_.end() ? to : std::min(to, next->first);
    if (seq < end) {
      ranges.push_back({seq, std::min(end, seq + budget) - 1});
      budget -= ranges.back().last - seq + 1;
    }
    if (next == messages_.end()) break;
    seq = next->first + 1;
    ++next;
  }
  return ranges;
}

void LossCount::AddRequested(const std::vector<SeqRange>& ranges) {
  for (const SeqRange& range : ranges) {
    lost_ += std::max<int64_t>(0, range.last + 1 - std::max({range.first, join_end_, requested_end_}));
    requested_end_ = std::max(requested_end_, range.last + 1);
  }
}

void LossCount::AddArrived(int64_t seq) {
  if (seq >= join_end_ && seq < requested_end_) ++repaired_;
}

void LossCount::AddGivenUp(int64_t from, int64_t to, bool two_way) {
  lost_ += std::max<int64_t>(0, two_way ? std::min({to, join_end_, requested_end_}) - from : to - from);
}

void AckTimer::OnDelivered(size_t size, int64_t now) {
  cost_ += WireCost(size);
  if (cost_ >= kPromptAckCost) time_ = now;
  Require(std::max(now, last_ + pause_ns_));
}

void AckTimer::Require(int64_t time) { time_ = std::min(time_, time); }

void AckTimer::OnSent(int64_t now) {
  last_ = now;
  cost_ = 0;
  time_ = INT64_MAX;
}

void GapPatience::Heard(int64_t now) {
  if (now - heard_ > times_.absent_ns) progress_ = now;
  heard_ = now;
}

bool GapPatience::HasExited(int64_t now) const {
  return now - heard_ > times_.silent_ns && now - progress_ > times_.silent_ns;
}

bool GapPatience::IsHopeless(int64_t now) const {
  return now - heard_ <= times_.absent_ns && now - progress_ > Limit(now);
}

/// If large messages hardly get through, more requests help as long as the publisher has the messages.
int64_t GapPatience::Limit(int64_t now) const {
  return now - kept_ < times_.absent_ns ? times_.kept_ns : times_.hopeless_ns;
}

int64_t GapPatience::EndTime() const {
  const int64_t exited = std::max(heard_, progress_) + times_.silent_ns + 1;
  // The earliest time that exceeds its `Limit`.
  const int64_t hopeless = std::min(progress_ + times_.kept_ns + 1,
                                    std::max(progress_ + times_.hopeless_ns + 1, kept_ + times_.absent_ns));
  return hopeless - heard_ <= times_.absent_ns ? std::min(exited, hopeless) : exited;
}

void GapRequests::SkipTo(int64_t seq) { requested_end_ = std::max(requested_end_, seq); }

void GapRequests::OnArrival() {
  if (answers_ == Answers::kNone) answers_ = Answers::kSome;
  has_new_gap_ = true;
}

void GapRequests::OnAnnounce() {
  if (answers_ == Answers::kSome) answers_ = Answers::kAll;
}

void GapRequests::Rest() {
  retry_at_ = INT64_MAX;
  pause_ns_ = retry_first_ns_;
}

void GapRequests::ScheduleRetry(int64_t now) {
  retry_at_ = now + pause_ns_;
  pause_ns_ = std::min(2 * pause_ns_, retry_max_ns_);
}

bool GapRequests::TakeHello(int64_t now) {
  if (retry_at_ != INT64_MAX && now < retry_at_) return false;
  ScheduleRetry(now);
  return true;
}

std::optional<std::vector<SeqRange>> GapRequests::Take(const EarlyMessages& early, int64_t expected, int64_t end,
                                                       int64_t now) {
  SkipTo(expected);
  if (answers_ == Answers::kAll || now >= retry_at_) {
    if (answers_ != Answers::kNone) pause_ns_ = retry_first_ns_;
    auto ranges = early.Missing(expected, end, kMaxAsked);
    requested_end_ = ranges.empty() ? requested_end_ : ranges.back().last + 1;
    ScheduleRetry(now);
    answers_ = Answers::kNone;
    has_new_gap_ = false;
    return ranges;
  }
  const int64_t asked = Count(early.Missing(expected, requested_end_, kMaxAsked));
  if (asked > kMaxAsked / 2) return std::nullopt;  // catching up: by batches, not one by one
  auto fresh = early.Missing(requested_end_, end, kMaxAsked - asked);
  has_new_gap_ = false;
  if (fresh.empty()) return std::nullopt;
  requested_end_ = fresh.back().last + 1;
  if (retry_at_ == INT64_MAX) ScheduleRetry(now);
  return fresh;
}

}  // namespace plslam::bus
