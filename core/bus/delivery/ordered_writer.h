// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <vector>

#include "core/bus/delivery/history.h"

namespace plslam::bus {

/// Readers of one channel that its publisher remembers.
inline constexpr size_t kMaxReaders = 256;

/// What a datagram of `bytes` takes of a receive buffer, by the kernel's way of counting (payload plus buffer heads).
constexpr int64_t WireCost(size_t bytes) { return static_cast<int64_t>(bytes + bytes / 16 + 2304); }

/// Numbers first..last, both included.
struct SeqRange {
  int64_t first = 0;
  int64_t last = -1;
};

/// The publisher's end of one ordered channel: history, readers, window, and when to announce. Time is handed in
/// (nanoseconds of any steady clock), so that tests need no clock; not thread-safe.
class OrderedWriter {
 public:
  struct Times {
    int64_t reader_alive_ns = 1'500'000'000;  ///< without a word for longer, a reader is not waited for
    int64_t reader_kept_ns = 60'000'000'000;  ///< nor kept messages for, after this
    /// After its first message a publisher forgets nothing for so long: those who read before it began may not have
    /// been heard yet, as their first words can be lost (ten of them are said in this time).
    int64_t greeting_ns = 3'000'000'000;
    /// A newcomer begins where the slowest reader heard within this time stands: it may be that one, started again.
    int64_t join_heard_ns = 3'000'000'000;
    int64_t announce_first_ns = 3'000'000;  ///< after sending, unless everybody has acknowledged by then
    int64_t announce_period_ns = 1'000'000'000;
    int64_t resend_pause_ns = 2'000'000;  ///< the same message is not sent again sooner (several readers ask)
  };

  OrderedWriter(Retention retention, int64_t memory_bytes) : history_(retention, memory_bytes) {}

  /// For how long after its last word messages are kept for a reader.
  void KeepReadersFor(int64_t ns) { times_.reader_kept_ns = ns; }

  /// Number of the next message.
  int64_t next_seq() const { return history_.next_seq(); }
  const History& history() const { return history_; }
  /// Where a reader begins that has nothing yet.
  int64_t join_seq(int64_t now) const;

  /// Whether a message of that size may go now without filling some reader's buffer.
  bool WindowOpen(size_t bytes, int64_t now) const;
  /// Stops waiting for those readers that keep the window shut, until they have caught up.
  void LeaveBehind(size_t bytes, int64_t now);

  /// The message `next_seq()` has been sent.
  void Sent(Bytes message, int64_t now);
  /// The oldest messages that memory has no room for, as `History` says.
  Bytes ToMove() const { return history_.ToMove(); }
  void Moved(std::optional<int64_t> offset) { history_.Moved(offset); }

  /// A reader's acknowledgement and request; returns the numbers to send again now, at most a window full. The
  /// reader wants an announcement after them (or alone) when `announce` comes back true.
  struct Answer {
    std::vector<History::Kept> resend;
    bool announce = false;
  };
  Answer OnRequest(int64_t reader, int64_t delivered, int64_t window, const std::vector<SeqRange>& ranges,
                   int64_t now);
  /// "I read this channel".
  void OnHello(int64_t reader, int64_t window, int64_t now);

  /// When `AnnounceDue` wants to be asked.
  int64_t announce_time() const { return next_announce_; }
  /// True when an announcement is to be sent now; schedules the next.
  bool AnnounceDue(int64_t now);

  /// Readers that spoke lately.
  int AliveReaders(int64_t now) const;
  bool AllDelivered(int64_t now) const;
  /// The same of those who have fallen silent, too, for as long as messages are kept for them.
  bool AllDeliveredToSilent(int64_t now) const;
  /// Grows with each word of a reader that tells of more than the one before.
  int64_t acknowledged() const { return acknowledged_; }

 private:
  struct Reader {
    int64_t delivered = -1;
    int64_t window = 0;
    int64_t heard = 0;
    bool behind = false;  // not waited for
  };

  bool Alive(const Reader& reader, int64_t now) const { return now - reader.heard <= times_.reader_alive_ns; }
  Reader& Heard(int64_t id, int64_t window, int64_t now);
  /// Cost of what was sent after `delivered`; nullopt where that is so long ago that it is not known.
  std::optional<int64_t> InFlight(int64_t delivered) const;
  bool Blocks(const Reader& reader, int64_t cost, int64_t now) const;
  bool AllDelivered(int64_t silence_ns, int64_t now) const;
  void Trim(int64_t now);

  Times times_;
  History history_;
  std::map<int64_t, Reader> readers_;
  std::deque<int64_t> cost_before_;  // total cost of all messages before each of the last ones
  int64_t total_cost_ = 0;
  int64_t acknowledged_ = 0;
  std::map<int64_t, int64_t> resent_at_;
  int64_t greeted_at_ = 0;  // nothing is forgotten before
  int64_t next_announce_ = 0;
  int announce_stage_ = 0;
};

}  // namespace plslam::bus
