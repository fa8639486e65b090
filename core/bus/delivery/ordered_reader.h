// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "core/bus/delivery/ordered_writer.h"
#include "core/bus/delivery/reader_parts.h"
#include "core/bus/transport/wire.h"

namespace plslam::bus {

/// The reader's end of one ordered channel of one publisher: puts messages in order, detects gaps, decides which
/// messages to request again and to acknowledge, and gives up unavailable ones. Time is passed in (nanoseconds of any
/// steady clock), so that tests need no clock; not thread-safe.
///
///   OnMessage / OnAnnounce  ->  while (Front()) { deliver; Pop(); }  ->  Poll() returns the request to send
class OrderedReader {
 public:
  static constexpr int64_t kSilent_ns = ReaderTimes{}.silent_ns;

  /// Acknowledgement and repair request to the publisher.
  struct Request {
    int64_t delivered = -1;
    std::vector<SeqRange> ranges;
  };

  enum class Arrival { kNew, kDuplicate, kRefused };

  /// `two_way` false: the publisher cannot be reached (a log); gaps are given up when many messages have arrived after
  /// them. `buffer_bytes` bounds the memory of messages out of order. `silent_ns`: see ReaderTimes.
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
  int64_t heard() const { return patience_.heard(); }
  int64_t buffered_bytes() const { return early_.bytes(); }
  /// Totals since the start (LossCount).
  int64_t lost() const { return losses_.lost(); }
  int64_t repaired() const { return losses_.repaired(); }

 private:
  enum class State {
    kUnknown,  ///< until the first number to deliver is known
    kOpen,     ///< until OnEnd
    kEnded,    ///< no message follows
  };

  bool HasGap() const { return state_ == State::kUnknown || expected_ + early_.size() < known_end_; }
  void Start(int64_t first, int64_t now);
  void SkipTo(int64_t seq);
  void GiveUp(int64_t now);
  std::optional<std::vector<SeqRange>> TakeRanges(int64_t now);
  bool IsOneWayGap() const;
  void Schedule();

  bool two_way_;
  State state_ = State::kUnknown;
  int64_t expected_ = 0;   // next to deliver, if known
  int64_t known_end_ = 0;  // one past the newest announced or received
  EarlyMessages early_;
  LossCount losses_;
  AckTimer acks_;
  GapPatience patience_;
  GapRequests requests_;
  int64_t poll_time_ = 0;
};

}  // namespace plslam::bus
