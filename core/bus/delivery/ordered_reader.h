// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <vector>

#include "core/bus/delivery/ordered_writer.h"
#include "core/bus/transport/wire.h"

namespace plslam::bus {

/// The reader's end of one ordered channel of one publisher: puts messages in order, detects gaps, decides which
/// messages to request again and to acknowledge, and gives up unavailable ones. Time is passed in (nanoseconds of any
/// steady clock), so that tests need no clock; not thread-safe.
///
///   OnMessage / OnAnnounce  ->  while (Front()) { deliver; Pop(); }  ->  Poll() returns the request to send
class OrderedReader {
 public:
  static constexpr int64_t kSilent_ns = 30'000'000'000;

  struct Times {
    int64_t retry_first_ns = 3'000'000;  ///< repeated after this without an answer, then doubled
    int64_t retry_max_ns = 200'000'000;
    int64_t ack_pause_ns = 2'000'000;      ///< small messages are acknowledged together
    int64_t silent_ns = kSilent_ns;        ///< a publisher silent for longer counts as exited: its gaps are given up
    int64_t hopeless_ns = 10'000'000'000;  ///< so is a gap that a running publisher does not fill
    int64_t kept_ns = 60'000'000'000;      ///< the same if it announces that it still has the missing messages
    int64_t absent_ns = 2'000'000'000;  ///< after a longer silence it is cut off, and its time for a gap is stopped
  };

  /// Acknowledgement and repair request to the publisher.
  struct Request {
    int64_t delivered = -1;
    std::vector<SeqRange> ranges;
  };

  enum class Arrival { kNew, kDuplicate, kRefused };

  /// `two_way` false: the publisher cannot be reached (a log); gaps are given up when many messages have arrived after
  /// them. `buffer_bytes` bounds the memory of messages out of order. `silent_ns`: see Times.
  OrderedReader(bool two_way, int64_t buffer_bytes, int64_t now, int64_t silent_ns = kSilent_ns);

  Arrival OnMessage(int64_t seq, ByteView bytes, int64_t now);
  /// `join_seq`: the first message to deliver if none has arrived yet, unless it is `first_seq`.
  void OnAnnounce(int64_t first_seq, int64_t next_seq, int64_t now, std::optional<int64_t> join_seq = std::nullopt);

  /// Returns the next message in order if it has arrived; nullptr otherwise.
  Bytes Front() const;
  /// It has been delivered.
  void Pop(int64_t now);

  /// The publisher cannot be reached, and no message follows: its gaps are given up.
  void OnEnd();

  /// Returns the request to send now, if any; also gives up hopeless gaps (check Front() again).
  std::optional<Request> Poll(int64_t now);
  /// The latest time of the next call of Poll.
  int64_t poll_time() const { return poll_time_; }

  int64_t delivered() const { return expected_ - 1; }
  int64_t heard() const { return heard_; }
  int64_t buffered_bytes() const { return buffered_bytes_; }
  /// Totals since the start: messages that had to be requested again (one-way: that were given up), and the number of
  /// them that were delivered after all. Numbers that were never requested do not count as lost, however far a forged
  /// message has jumped.
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
  bool started_ = false;   // whether `expected_` is valid
  int64_t expected_ = 0;   // next to deliver
  int64_t known_end_ = 0;  // one past the newest announced or received
  int64_t join_end_ = 0;   // earlier ones were sent before this reader joined: not lost on the wire
  std::map<int64_t, Bytes> buffer_;
  int64_t buffered_bytes_ = 0;
  int64_t heard_ = 0;
  int64_t progress_ = 0;  // time of the last arrival that filled a gap, or of the gap's begin
  int64_t kept_ = 0;      // time when the publisher last announced that it has the missing messages
  bool ended_ = false;
  bool progressed_ = false;  // since the last request
  int64_t asked_end_ = 0;    // all missing ones below have been requested
  int64_t counted_end_ = 0;  // the same, since the start, regardless of repeated requests
  int64_t retry_at_ = kFar;
  int64_t retry_pause_ = 0;
  bool ask_now_ = false;
  bool fresh_ = false;  // there may be gaps that were not requested yet
  int64_t ack_at_ = kFar;
  int64_t last_ack_ = 0;
  int64_t unacked_cost_ = 0;
  int64_t poll_time_ = 0;
  int64_t lost_ = 0;
  int64_t repaired_ = 0;
};

}  // namespace plslam::bus
