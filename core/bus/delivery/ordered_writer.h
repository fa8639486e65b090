// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <vector>

#include "core/bus/delivery/history.h"
#include "core/bus/delivery/message_size.h"
#include "core/ids/ids.h"

namespace plslam::bus {

/// Readers of one channel that its publisher remembers.
inline constexpr size_t kMaxReaders = 256;

/// Returns the bytes that a datagram of `bytes` takes in a receive buffer, as the kernel counts (payload plus buffer
/// heads).
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
    int64_t reader_alive_ns = 1'500'000'000;  ///< a reader that is silent for longer is not waited for
    int64_t reader_kept_ns = 60'000'000'000;  ///< and messages are not kept for it after this
    /// After its first message a publisher drops no messages for this time: earlier readers may not have been heard
    /// yet, as their first messages can be lost (ten of them are sent in this time).
    int64_t greeting_ns = 3'000'000'000;
    /// A new reader begins at the position of the slowest reader that was heard within this time, which may be its
    /// predecessor.
    int64_t join_heard_ns = 3'000'000'000;
    int64_t announce_first_ns = 3'000'000;  ///< after sending, unless all readers have acknowledged by then
    int64_t announce_period_ns = 1'000'000'000;
    int64_t resend_pause_ns = 2'000'000;  ///< a message is not resent sooner (several readers request it)
  };

  OrderedWriter(Retention retention, int64_t memory_bytes) : history_(retention, memory_bytes) {}

  /// Sets how long messages are kept after a reader's last acknowledgement.
  void KeepReadersFor(int64_t ns) { times_.reader_kept_ns = ns; }

  /// Number of the next message.
  int64_t next_seq() const { return history_.next_seq(); }
  const History& history() const { return history_; }
  /// First message for a reader that has none yet.
  int64_t join_seq(int64_t now) const;

  /// Returns whether a message of that size may be sent now without overflowing the buffer of any reader.
  bool WindowOpen(size_t bytes, int64_t now) const;
  /// Stops waiting for the readers that keep the window shut, until they have caught up.
  void SuspendSlowReaders(size_t bytes, int64_t now);

  /// The message `next_seq()` has been sent.
  void Sent(Bytes message, int64_t now);
  /// Returns the oldest messages beyond the bound of memory, as `History::ToMove`.
  Bytes ToMove() const { return history_.ToMove(); }
  int64_t Moved(std::optional<int64_t> offset) { return history_.Moved(offset); }

  /// Handles a reader's acknowledgement and request; returns the messages to resend now, at most a window full. If
  /// `announce` is true, an announcement follows them (or is sent alone).
  struct Answer {
    std::vector<History::Kept> resend;
    /// Number of recent messages larger than `MessageSize::kPacket_bytes` that a known reader requests for the first
    /// time: they were lost.
    int64_t n_lost = 0;
    bool announce = false;
  };
  Answer OnRequest(SourceId reader, int64_t delivered, int64_t window, const std::vector<SeqRange>& ranges,
                   int64_t now);
  /// Registers a reader of this channel.
  void OnHello(SourceId reader, int64_t window, int64_t now);

  /// The next time to call `AnnounceDue`.
  int64_t announce_time() const { return next_announce_; }
  /// Returns true when an announcement is to be sent now, and schedules the next.
  bool AnnounceDue(int64_t now);

  /// Number of readers heard within `reader_alive_ns`.
  int AliveReaders(int64_t now) const;
  bool AllDelivered(int64_t now) const;
  /// Like `AllDelivered`, but includes readers that have fallen silent, as long as messages are kept for them.
  bool AllDeliveredToSilent(int64_t now) const;
  /// Number of acknowledgements that confirmed more messages than the one before.
  int64_t acknowledged() const { return acknowledged_; }

 private:
  struct Reader {
    int64_t delivered = -1;
    int64_t window = 0;
    int64_t heard = 0;
    bool behind = false;  // not waited for
  };

  bool Alive(const Reader& reader, int64_t now) const { return now - reader.heard <= times_.reader_alive_ns; }
  Reader& Heard(SourceId id, int64_t window, int64_t now);
  /// Returns the cost of the messages after `delivered`; nullopt if they are too old to be known.
  std::optional<int64_t> InFlight(int64_t delivered) const;
  bool Blocks(const Reader& reader, int64_t cost, int64_t now) const;
  bool AllDelivered(int64_t silence_ns, int64_t now) const;
  void Trim(int64_t now);

  Times times_;
  History history_;
  std::map<SourceId, Reader> readers_;
  std::deque<int64_t> cost_before_;  // total cost of all messages before each of the last ones
  int64_t total_cost_ = 0;
  int64_t acknowledged_ = 0;
  std::map<int64_t, int64_t> resent_at_;
  int64_t greeted_at_ = 0;  // no messages are dropped before
  int64_t next_announce_ = 0;
  int announce_stage_ = 0;
};

}  // namespace plslam::bus
