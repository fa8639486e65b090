// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/bus/channel_names.h"
#include "core/bus/delivery/ordered_writer.h"
#include "core/bus/options.h"
#include "core/bus/transport/authenticator.h"
#include "core/bus/transport/transport.h"
#include "core/ids/ids.h"

namespace plslam {
class header_t;
}

namespace plslam::bus {

/// The publishing half of a bus: numbers messages, seals and sends them, keeps them for repair requests, and waits for
/// slow readers. Used by publishing threads and by the receiving thread, which handles acknowledgements; one mutex
/// guards the bookkeeping, and no message is encoded, sent, written to disk or read from it while that is locked.
class Outboxes {
 public:
  using Encode = std::function<int(void* buffer, int size)>;
  /// A reader that is silent for longer is forgotten, in nanoseconds.
  static constexpr int64_t kRemembered_ns = 60'000'000'000;

  /// Content of an announcement about one ordered channel (`announce_t`).
  struct Announcement {
    Channel channel;
    int64_t first_seq = 0;
    int64_t next_seq = 0;
    int64_t join_seq = 0;
  };
  /// Messages to send in reply to a reader: resent messages, then an announcement.
  struct Answer {
    std::string wire_name;
    std::vector<Bytes> resend;
    std::optional<Announcement> announcement;
  };

  /// All references must outlive this object. Throws std::runtime_error if the folder of histories is not usable.
  Outboxes(const BusOptions& options, const ChannelNames& names, const Authenticator& authenticator,
           Transport& transport, SourceId source);

  /// Fills in the header and sends; safe from any thread; waits for readers as `Bus::Publish` does. Returns the time of
  /// the channel's next announcement, in nanoseconds; nullopt if it has none.
  std::optional<int64_t> Publish(const Channel& channel, header_t& header, const std::function<int()>& encoded_size,
                                 const Encode& encode);
  /// See `Bus::Flush` and `Bus::FlushToSilent`.
  bool Flush(std::chrono::milliseconds limit, bool to_silent);
  /// From now on readers in lockstep are waited for no longer than others: this process ends.
  void Stop() { stopped_ = true; }

  int ReaderCount(const Channel& channel) const;
  int64_t acknowledged() const;
  int64_t sent() const { return sent_; }
  int64_t resent() const { return resent_; }
  /// Sends a message of a channel that is repaired, in packets while packets are lost.
  void SendRepairable(const std::string& wire_name, ByteView message);

  /// Whether pages and strips are single packets now, because too many larger messages were lost (`MessageSize`).
  bool sends_packets() const;
  /// A line about that, empty if it is not so.
  std::string LossText() const;

  // The following functions are called on the receiving thread.

  /// Handles a new reader of this channel, even if this process does not publish it (yet).
  std::optional<Announcement> OnHello(const Channel& channel, SourceId reader, int64_t window, int64_t now);
  /// Handles a reader's acknowledgement and request; empty if this process does not publish the channel.
  Answer OnRequest(const std::string& channel, SourceId reader, int64_t delivered, int64_t window,
                   const std::vector<SeqRange>& ranges, int64_t now);
  /// Returns the due announcements; lowers `next` to the time of the next one.
  std::vector<Announcement> Poll(int64_t now, int64_t& next);

 private:
  /// One published channel. `publish_mutex` is held for one message, from its number to the wire; `writer` and `sent`
  /// are guarded by `mutex_`, the rest by `publish_mutex`.
  struct Outbox {
    Channel channel;
    std::string wire_name;
    std::string map_name;  // kToMap: second name under which it is sent; empty: none
    std::mutex publish_mutex;
    int64_t seq = 0;
    int64_t sent = 0;                       // one past the newest that has been handed to LCM
    std::unique_ptr<OrderedWriter> writer;  // ordered and paced channels
    std::unique_ptr<HistoryLog> log;        // the same; the receiving thread reads the stored messages
  };
  struct Hello {
    int64_t heard = 0;
    int64_t window = 0;
  };

  Outbox& OutboxOf(const Channel& channel);
  Bytes Sealed(const std::string& wire_name, int64_t seq, header_t& header, const std::function<int()>& encoded_size,
               const Encode& encode) const;
  void WaitForWindow(Outbox& outbox, size_t bytes);
  void MoveToLog(Outbox& outbox);
  /// Silence, in nanoseconds, after which a reader with a full window is not waited for.
  int64_t PatienceWithReaders(const Channel& channel) const;
  Announcement AnnouncementOf(const Outbox& outbox, int64_t now) const;

  const BusOptions& options_;
  const ChannelNames& names_;
  const Authenticator& authenticator_;
  Transport& transport_;
  SourceId source_;
  std::string history_folder_;
  std::atomic<bool> stopped_{false};
  std::atomic<int64_t> sent_{0};
  std::atomic<int64_t> resent_{0};

  mutable std::mutex mutex_;
  MessageSize size_;                                                      // guarded by `mutex_`
  std::condition_variable acknowledged_;                                  // an acknowledgement has arrived
  std::map<std::string, std::unique_ptr<Outbox>, std::less<>> outboxes_;  // by channel name
  std::map<std::string, std::map<SourceId, Hello>, std::less<>> hellos_;  // by channel name, of the whole table
};

/// Nanoseconds of the steady clock, in which everything on the bus is timed, and a millisecond of them.
int64_t SteadyNow_ns();
inline constexpr int64_t kMs = 1'000'000;

}  // namespace plslam::bus
