// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <vector>

#include "core/bus/delivery/ordered_writer.h"
#include "core/bus/transport/wire.h"

namespace plslam::bus {

/// The reader's end of one ordered channel of one publisher: puts messages in order, notices gaps, says what to ask
/// for again and what to acknowledge, and gives up what cannot be had. Time is handed in (nanoseconds of any steady
/// clock), so that tests need no clock; not thread-safe.
///
///   OnMessage / OnAnnounce  ->  while (Front()) { deliver; Pop(); }  ->  Poll() says what to send
class OrderedReader {
 public:
  static constexpr int64_t kSilent_ns = 30'000'000'000;

  struct Times {
    int64_t retry_first_ns = 5'000'000;  ///< asked again after this without an answer, then doubled
    int64_t retry_max_ns = 200'000'000;
    int64_t ack_pause_ns = 2'000'000;      ///< small messages are acknowledged together
    int64_t silent_ns = kSilent_ns;        ///< a publisher not heard for longer is dead: its gaps are given up
    int64_t hopeless_ns = 10'000'000'000;  ///< so is a gap that a living publisher does not fill
    int64_t kept_ns = 60'000'000'000;      ///< the same where it says that it still has what is missing
    int64_t absent_ns = 2'000'000'000;  ///< not heard for longer it is cut off, and its time for a gap stands still
  };

  /// What to tell the publisher.
  struct Request {
    int64_t delivered = -1;
    std::vector<SeqRange> ranges;
  };

  enum class Arrival { kNew, kDuplicate, kRefused };

  /// `two_way` false: the publisher cannot be asked (a log); gaps are given up when much has come after them.
  /// `buffer_bytes` bounds what is held out of order. `silent_ns`: see Times.
  OrderedReader(bool two_way, int64_t buffer_bytes, int64_t now, int64_t silent_ns = kSilent_ns);

  Arrival OnMessage(int64_t seq, ByteView bytes, int64_t now);
  /// `join_seq`: where to begin when nothing has come yet, if not at `first_seq`.
  void OnAnnounce(int64_t first_seq, int64_t next_seq, int64_t now, std::optional<int64_t> join_seq = std::nullopt);

  /// The next message in order if it is there; nullptr else.
  Bytes Front() const;
  /// It has been delivered.
  void Pop(int64_t now);

  /// The publisher cannot be asked, and nothing more comes: its gaps are given up.
  void OnEnd();

  /// What to send now, if anything; also gives up what is hopeless (look at Front() again).
  std::optional<Request> Poll(int64_t now);
  /// When Poll wants to be called at the latest.
  int64_t poll_time() const { return poll_time_; }

  int64_t delivered() const { return expected_ - 1; }
  int64_t heard() const { return heard_; }
  int64_t buffered_bytes() const { return buffered_bytes_; }
  /// Totals since the start: messages that had to be asked for again (where nobody can be asked: that were given up),
  /// and of those delivered after all. Numbers that were never asked for are not lost, however far a message that
  /// somebody forged has jumped.
  int64_t lost() const { return lost_; }
  int64_t repaired() const { return repaired_; }

 private:
  static constexpr int64_t kFar = INT64_MAX;

  bool HasGap() const { return !started_ || expected_ + static_cast<int64_t>(buffer_.size()) < known_end_; }
  void Heard(int64_t now);
  void Start(int64_t first, int64_t now);
  void CountAsked(const std::vector<SeqRange>& ranges);
  void SkipTo(int64_t seq);
  void GiveUp(int64_t now);
  std::vector<SeqRange> Missing(int64_t from, int64_t to, int64_t budget) const;
  std::optional<std::vector<SeqRange>> Asking(int64_t now);
  int64_t GiveUpTime() const;
  int64_t Patience(int64_t now) const;
  bool IsOneWayGap() const;
  void Schedule();

  Times times_;
  bool two_way_;
  int64_t buffer_limit_;
  bool started_ = false;   // `expected_` is known
  int64_t expected_ = 0;   // next to deliver
  int64_t known_end_ = 0;  // one past the newest known to exist
  int64_t join_end_ = 0;   // what is older was sent before we listened: not lost on the wire
  std::map<int64_t, Bytes> buffer_;
  int64_t buffered_bytes_ = 0;
  int64_t heard_ = 0;
  int64_t progress_ = 0;  // time of the last arrival that filled a gap, or of the gap's begin
  int64_t kept_ = 0;      // time when the publisher last said that it has what is missing
  bool ended_ = false;
  bool progressed_ = false;  // since the last request
  int64_t asked_end_ = 0;    // everything missing below has been asked for
  int64_t counted_end_ = 0;  // the same, since the start, whatever is asked for again
  int64_t retry_at_ = kFar;
  int64_t retry_pause_ = 0;
  bool ask_now_ = false;
  bool fresh_ = false;  // there may be gaps not asked for yet
  int64_t ack_at_ = kFar;
  int64_t last_ack_ = 0;
  int64_t unacked_cost_ = 0;
  int64_t poll_time_ = 0;
  int64_t lost_ = 0;
  int64_t repaired_ = 0;
};

}  // namespace plslam::bus
