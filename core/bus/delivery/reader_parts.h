// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <vector>

#include "core/bus/delivery/ordered_writer.h"
#include "core/bus/transport/wire.h"

// The parts of an OrderedReader. Times are nanoseconds of any steady clock.

namespace plslam::bus {

struct ReaderTimes {
  int64_t retry_first_ns = 3'000'000;  ///< repeated after this without an answer, then doubled
  int64_t retry_max_ns = 200'000'000;
  int64_t ack_pause_ns = 2'000'000;      ///< small messages are acknowledged together
  int64_t silent_ns = 30'000'000'000;    ///< a publisher silent for longer counts as exited: its gaps are given up
  int64_t hopeless_ns = 10'000'000'000;  ///< so is a gap that a running publisher does not fill
  int64_t kept_ns = 60'000'000'000;      ///< the same if it announces that it still has the missing messages
  int64_t absent_ns = 2'000'000'000;     ///< after a longer silence it is cut off, and its time for a gap is stopped
};

/// Messages that have arrived and are not delivered yet, by number.
class EarlyMessages {
 public:
  explicit EarlyMessages(int64_t limit_bytes) : limit_bytes_(limit_bytes) {}

  void Add(int64_t seq, ByteView bytes);
  /// Removes the first, and returns its size.
  size_t Pop();

  bool Contains(int64_t seq) const { return messages_.contains(seq); }
  bool HasRoomFor(size_t size) const { return bytes_ + static_cast<int64_t>(size) <= limit_bytes_; }
  bool empty() const { return messages_.empty(); }
  int64_t size() const { return static_cast<int64_t>(messages_.size()); }
  int64_t bytes() const { return bytes_; }
  int64_t first_seq() const { return messages_.begin()->first; }
  const Bytes& first() const { return messages_.begin()->second; }
  /// Returns the missing numbers of [from, to), at most `budget` of them in a bounded number of ranges.
  std::vector<SeqRange> Missing(int64_t from, int64_t to, int64_t budget) const;

 private:
  std::map<int64_t, Bytes> messages_;
  int64_t bytes_ = 0;
  int64_t limit_bytes_;
};

/// Counts the messages that had to be requested again (one-way: that were given up), and those of them that arrived
/// after all. Numbers that were never requested do not count as lost, however far a forged message has jumped.
class LossCount {
 public:
  /// Messages before `end` were sent before this reader joined: not lost on the wire.
  void Join(int64_t end) { join_end_ = end; }
  void AddRequested(const std::vector<SeqRange>& ranges);
  void AddArrived(int64_t seq);
  /// Messages sent before this reader joined count as lost only when they are given up.
  void AddGivenUp(int64_t from, int64_t to, bool two_way);

  int64_t lost() const { return lost_; }
  int64_t repaired() const { return repaired_; }

 private:
  int64_t join_end_ = 0;
  int64_t requested_end_ = 0;  // all before were requested, or have arrived
  int64_t lost_ = 0;
  int64_t repaired_ = 0;
};

/// When to acknowledge: large messages one by one, since the window holds few of them, small ones together.
class AckTimer {
 public:
  explicit AckTimer(int64_t pause_ns) : pause_ns_(pause_ns) {}

  void OnDelivered(size_t size, int64_t now);
  /// Acknowledges at that time, or earlier.
  void Require(int64_t time);
  /// Acknowledges when the pause after the last acknowledgement is over.
  void RequireAfterPause() { Require(last_ + pause_ns_); }
  void OnSent(int64_t now);

  int64_t time() const { return time_; }
  int64_t pause_ns() const { return pause_ns_; }

 private:
  int64_t pause_ns_;
  int64_t time_ = INT64_MAX;
  int64_t last_ = 0;
  int64_t cost_ = 0;  // of messages delivered since
};

/// How long to wait for a gap.
class GapPatience {
 public:
  GapPatience(const ReaderTimes& times, int64_t now)
      : times_(times), heard_(now), progress_(now), kept_(now - times.absent_ns) {}

  /// The publisher was heard.
  void Heard(int64_t now);
  /// It has announced that it has the missing messages.
  void Kept(int64_t now) { kept_ = now; }
  /// A gap has begun, or a message of it has arrived, at that time.
  void Progress(int64_t time) { progress_ = time; }

  bool HasExited(int64_t now) const;
  /// Returns whether the publisher is running, and will not fill the gap.
  bool IsHopeless(int64_t now) const;
  /// Returns the time when one of the two becomes true if no message arrives until then.
  int64_t EndTime() const;
  int64_t heard() const { return heard_; }

 private:
  int64_t Limit(int64_t now) const;

  ReaderTimes times_;
  int64_t heard_;
  int64_t progress_;
  int64_t kept_;
};

/// Which missing messages to request, and when: new gaps at once; everything that is missing when the last request has
/// been answered, or has timed out.
class GapRequests {
 public:
  explicit GapRequests(const ReaderTimes& times)
      : retry_first_ns_(times.retry_first_ns), retry_max_ns_(times.retry_max_ns), pause_ns_(times.retry_first_ns) {}

  /// The first number to deliver is known; earlier ones are not requested.
  void Begin(int64_t first) { requested_end_ = first; }
  /// Earlier numbers are delivered, or given up.
  void SkipTo(int64_t seq);
  /// There is a gap that was not requested yet.
  void OnGap() { has_new_gap_ = true; }
  /// A missing message has arrived.
  void OnArrival();
  /// The publisher announces what it has, which also ends a batch of resent messages.
  void OnAnnounce();

  /// No message is missing.
  void Rest();
  /// Asks for the first number, which is unknown: the publisher answers an empty request with an announcement. Returns
  /// whether to send it now.
  bool TakeHello(int64_t now);
  /// Returns the ranges of [expected, end) to request now, if any.
  std::optional<std::vector<SeqRange>> Take(const EarlyMessages& early, int64_t expected, int64_t end, int64_t now);

  bool IsDueAtOnce() const { return answers_ == Answers::kAll || has_new_gap_ || retry_at_ == INT64_MAX; }
  int64_t retry_time() const { return retry_at_; }

 private:
  /// Answers to the last request.
  enum class Answers {
    kNone,  ///< until a missing message arrives, or the request is repeated
    kSome,  ///< until the publisher announces the end of its batch
    kAll,   ///< until the rest is requested, at once
  };

  void ScheduleRetry(int64_t now);

  int64_t retry_first_ns_;
  int64_t retry_max_ns_;
  int64_t requested_end_ = 0;  // all missing ones below have been requested
  bool has_new_gap_ = false;   // there may be gaps that were not requested yet
  Answers answers_ = Answers::kNone;
  int64_t retry_at_ = INT64_MAX;
  int64_t pause_ns_;  // before the next repetition
};

}  // namespace plslam::bus
