// SPDX-License-Identifier: BSD-3-Clause
#include "core/bus/delivery/ordered_writer.h"

#include <algorithm>
#include <array>
#include <limits>
#include <utility>

namespace plslam::bus {
namespace {

constexpr size_t kCostsKept = 4096;
constexpr size_t kMaxResentNoted = 4096;
// A reader that starts requests older ones, which were not lost.
constexpr int64_t kRecentMessages = 200;
constexpr int64_t kMinWindow = 64'000;
constexpr int64_t kMaxWindow = 1'000'000;

}  // namespace

std::optional<int64_t> OrderedWriter::InFlight(int64_t delivered) const {
  const int64_t oldest = history_.next_seq() - static_cast<int64_t>(cost_before_.size());
  const int64_t first = delivered + 1;
  if (first >= history_.next_seq()) return 0;
  if (first < oldest) return std::nullopt;
  return total_cost_ - cost_before_[static_cast<size_t>(first - oldest)];
}

bool OrderedWriter::Blocks(const Reader& reader, int64_t cost, int64_t now) const {
  if (reader.behind || !Alive(reader, now)) return false;
  const auto in_flight = InFlight(reader.delivered);
  return in_flight && *in_flight > 0 && *in_flight + cost > reader.window;
}

bool OrderedWriter::WindowOpen(size_t bytes, int64_t now) const {
  return std::none_of(readers_.begin(), readers_.end(),
                      [&](const auto& entry) { return Blocks(entry.second, WireCost(bytes), now); });
}

void OrderedWriter::SuspendSlowReaders(size_t bytes, int64_t now) {
  for (auto& [id, reader] : readers_) {
    if (Blocks(reader, WireCost(bytes), now)) reader.behind = true;
  }
}

void OrderedWriter::Sent(Bytes message, int64_t now) {
  if (history_.next_seq() == 0) greeted_at_ = now + times_.greeting_ns;
  cost_before_.push_back(total_cost_);
  if (cost_before_.size() > kCostsKept) cost_before_.pop_front();
  total_cost_ += WireCost(message->size());
  history_.Append(std::move(message));
  announce_stage_ = 0;
  const int64_t soon = now + (AliveReaders(now) > 0 ? 1 : 4) * times_.announce_first_ns;
  next_announce_ = std::min(next_announce_, soon);
}

OrderedWriter::Reader& OrderedWriter::Heard(SourceId id, int64_t window, int64_t now) {
  auto found = readers_.find(id);
  if (found == readers_.end()) {
    if (readers_.size() >= kMaxReaders) {
      const auto oldest = std::min_element(readers_.begin(), readers_.end(), [](const auto& a, const auto& b) {
        return a.second.heard < b.second.heard;
      });
      readers_.erase(oldest);
    }
    found = readers_.emplace(id, Reader{}).first;
    const auto in_flight = InFlight(-1);
    found->second.behind = !in_flight || *in_flight > 0;
  }
  found->second.heard = now;
  found->second.window = std::clamp(window, kMinWindow, kMaxWindow);
  return found->second;
}

void OrderedWriter::OnHello(SourceId reader, int64_t window, int64_t now) {
  const bool is_new = !readers_.contains(reader);
  Heard(reader, window, now);
  if (is_new && history_.next_seq() > 0) next_announce_ = std::min(next_announce_, now);
}

OrderedWriter::Answer OrderedWriter::OnRequest(SourceId id, int64_t delivered, int64_t window,
                                               const std::vector<SeqRange>& ranges, int64_t now) {
  Reader& reader = Heard(id, window, now);
  // An acknowledgement of unsent messages is ignored, and so is an older one that arrives late.
  if (delivered < history_.next_seq() && delivered > reader.delivered) {
    reader.delivered = delivered;
    ++acknowledged_;
  }
  const auto in_flight = InFlight(reader.delivered);
  if (in_flight && *in_flight <= reader.window) reader.behind = false;
  Trim(now);

  Answer answer;
  answer.announce = !ranges.empty() || delivered < 0;
  int64_t cost = 0;
  if (resent_at_.size() > kMaxResentNoted) resent_at_.clear();
  for (const SeqRange& range : ranges) {
    const int64_t last = std::min(range.last, history_.next_seq() - 1);
    for (int64_t seq = std::max(range.first, history_.first_seq()); seq <= last; ++seq) {
      const auto [noted, is_new] = resent_at_.try_emplace(seq, now);
      if (!is_new && now - noted->second < times_.resend_pause_ns) continue;
      std::optional<History::Kept> kept = history_.Find(seq);
      if (!kept) continue;
      cost += WireCost(kept->bytes);
      if (cost > reader.window && !answer.resend.empty()) {
        if (is_new) resent_at_.erase(noted);
        return answer;
      }
      noted->second = now;
      const bool is_lost = is_new && reader.delivered >= 0 && seq >= history_.next_seq() - kRecentMessages;
      if (is_lost && static_cast<int64_t>(kept->bytes) > MessageSize::kPacket_bytes) ++answer.n_lost;
      answer.resend.push_back(std::move(*kept));
    }
  }
  return answer;
}

/// Drops the messages that every reader has, and readers that have been silent for long. Without any reader, and as
/// long as readers may not have been heard yet, only the bound of the history applies.
void OrderedWriter::Trim(int64_t now) {
  std::erase_if(readers_, [&](const auto& entry) { return now - entry.second.heard > times_.reader_kept_ns; });
  if (readers_.empty() || now < greeted_at_) return;
  int64_t least = std::numeric_limits<int64_t>::max();
  for (const auto& [id, reader] : readers_) least = std::min(least, reader.delivered);
  history_.Forget(least + 1);
}

/// Messages are kept for readers that are cut off or have exited; a new reader need not receive those.
int64_t OrderedWriter::join_seq(int64_t now) const {
  if (history_.retention() == Retention::kAll || now < greeted_at_) return history_.first_seq();
  // Readers that have not acknowledged any message are new themselves.
  int64_t since = now - times_.join_heard_ns;
  int64_t newest_word = std::numeric_limits<int64_t>::min();
  for (const auto& [id, reader] : readers_) {
    if (reader.delivered >= 0) newest_word = std::max(newest_word, reader.heard);
  }
  since = std::min(since, newest_word);
  int64_t least = std::numeric_limits<int64_t>::max();
  for (const auto& [id, reader] : readers_) {
    if (reader.delivered >= 0 && reader.heard >= since) least = std::min(least, reader.delivered);
  }
  return least == std::numeric_limits<int64_t>::max() ? history_.first_seq()
                                                      : std::max(history_.first_seq(), least + 1);
}

bool OrderedWriter::AnnounceDue(int64_t now) {
  if (now < next_announce_) return false;
  static constexpr std::array<int64_t, 6> kPauses_ns = {5'000'000,  10'000'000, 20'000'000,
                                                        40'000'000, 80'000'000, 150'000'000};
  const bool waiting = AliveReaders(now) > 0 && !AllDelivered(now);
  const bool everybody_has_it = AliveReaders(now) > 0 && !waiting;
  const bool first = announce_stage_ == 0;
  const auto pause = kPauses_ns[std::min(static_cast<size_t>(announce_stage_), kPauses_ns.size() - 1)];
  next_announce_ = now + (waiting ? pause : times_.announce_period_ns);
  ++announce_stage_;
  return history_.next_seq() > 0 && !(first && everybody_has_it);
}

int OrderedWriter::AliveReaders(int64_t now) const {
  return static_cast<int>(
      std::count_if(readers_.begin(), readers_.end(), [&](const auto& e) { return Alive(e.second, now); }));
}

bool OrderedWriter::AllDelivered(int64_t now) const { return AllDelivered(times_.reader_alive_ns, now); }
bool OrderedWriter::AllDeliveredToSilent(int64_t now) const { return AllDelivered(times_.reader_kept_ns, now); }

/// Returns whether all readers that were heard within `silence_ns` have everything.
bool OrderedWriter::AllDelivered(int64_t silence_ns, int64_t now) const {
  return std::all_of(readers_.begin(), readers_.end(), [&](const auto& entry) {
    const Reader& reader = entry.second;
    return now - reader.heard > silence_ns || reader.delivered + 1 >= history_.next_seq();
  });
}

}  // namespace plslam::bus
