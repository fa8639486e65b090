// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <string_view>
#include <vector>

#include "core/bus/channels.h"
#include "core/bus/delivery/ordered_reader.h"
#include "core/bus/options.h"
#include "core/bus/run_loop.h"
#include "core/bus/transport/wire.h"
#include "core/ids/ids.h"

namespace plslam::bus {

/// One call of `Bus::Subscribe` and its kin.
struct Subscription {
  enum class Kind { kOrdered, kAsItComes, kNewest, kOrderedBytes, kBytes, kPacedBytes };
  Kind kind;
  std::function<bool(ByteView)> deliver;  ///< on the thread of Run, or (bytes) on the receiving thread
  std::function<bool()> ready;            ///< kOrderedBytes: whether it can take one now
};

/// Counters of messages, which the receiving thread and assemblers on any thread write.
struct ReceiverCounts {
  std::atomic<int64_t> received{0};
  std::atomic<int64_t> rejected{0};
  std::atomic<int64_t> unproven{0};
  std::atomic<int64_t> duplicates{0};
  std::atomic<int64_t> skipped{0};
  std::atomic<int64_t> lost{0};
  std::atomic<int64_t> repaired{0};

  /// `lost` by channel, which is by link: a channel has one publisher, or one on each host.
  void AddLost(std::string_view channel, int64_t n) {
    if (n == 0) return;
    lost += n;
    const std::scoped_lock lock(mutex_);
    lost_of_[std::string(channel)] += n;
  }
  std::map<std::string, int64_t> lost_of() const {
    const std::scoped_lock lock(mutex_);
    return lost_of_;
  }

 private:
  mutable std::mutex mutex_;
  std::map<std::string, int64_t> lost_of_;
};

/// The receiving half of a bus: orders messages for each publisher, acknowledges them, requests missing ones, and
/// passes messages to subscriptions. All members are used by the receiving thread, so handlers of bytes run without any
/// lock; only `Add`, `AddRest` and `Close` may be called from other threads.
class Inboxes {
 public:
  /// Sends an acknowledgement and request about `channel` to `publisher` (0: to all, as a new reader).
  using Ask = std::function<void(const Channel& channel, SourceId publisher, const OrderedReader::Request& request)>;
  using Rest = std::function<void(std::string_view wire_name, ByteView bytes)>;

  /// All references must outlive this object. `two_way`: publishers can be reached.
  Inboxes(const BusOptions& options, bool two_way, RunLoop& loop, ReceiverCounts& counts, Ask ask);

  /// Takes effect before the next datagram, or at the next poll of the receiving thread.
  void Add(const std::string& wire_name, const Channel& channel, const MessageLayout* layout,
           std::shared_ptr<Subscription> subscription);
  /// Subscribes to the bytes of messages without another subscription.
  void AddRest(Rest rest);
  /// Accepts no messages of ordered channels after the next poll of the receiving thread; `then` is called when all
  /// accepted messages are in the queue of the run loop.
  void Close(std::function<void()> then);

  // The following functions are called on the receiving thread.

  /// Returns the layout of the messages with this name; nullptr without a subscriber.
  const MessageLayout* LayoutOf(std::string_view wire_name);
  void TakeRest(std::string_view wire_name, ByteView bytes) const;
  /// A checked message of a name that has a layout.
  void Dispatch(std::string_view wire_name, const WireHeader& header, ByteView message, int64_t now);
  /// Handles the announcement of `publisher` about the messages that it has of the channel `wire_name`.
  void OnAnnounce(std::string_view wire_name, SourceId publisher, int64_t first_seq, int64_t next_seq,
                  int64_t join_seq, int64_t now);
  /// Sends due requests and delivers messages as far as handlers can take them; lowers `next` to the time of the next
  /// poll.
  void Poll(int64_t now, int64_t& next);
  /// Gives up the gaps that are left at the end of a log.
  void OnEnd();

 private:
  /// The newest message of one publisher of a kLatest channel that waits for one handler.
  struct LatestSlot {
    std::mutex mutex;
    Bytes newest;  // nullptr: none waits
  };
  struct Latest {
    int64_t seq = -1;
    int64_t heard = 0;
    std::vector<std::shared_ptr<LatestSlot>> slots;  // one for each subscription
  };
  /// One publisher of an ordered channel, and the counts of its reader that have been added up.
  struct Source {
    OrderedReader reader;
    int64_t lost = 0;
    int64_t repaired = 0;
  };
  /// Everything of one subscribed channel.
  struct Inbox {
    Channel channel;
    const MessageLayout* layout = nullptr;
    std::vector<std::shared_ptr<Subscription>> subscriptions;
    bool ordered = false;  // a subscriber needs order and repair
    std::map<SourceId, Source> sources;
    std::map<SourceId, Latest> latest;
    bool paced = false;
    std::map<SourceId, int64_t> unacknowledged;  // cost by publisher, if paced
    int64_t next_hello = 0;
  };
  struct Addition {
    std::string wire_name;
    Channel channel;
    const MessageLayout* layout = nullptr;
    std::shared_ptr<Subscription> subscription;
  };

  void TakeOrders();
  Source* SourceOf(Inbox& inbox, SourceId publisher, int64_t now);
  void DispatchPaced(Inbox& inbox, const WireHeader& header, ByteView message);
  void DispatchOrdered(Inbox& inbox, const WireHeader& header, ByteView message, int64_t now);
  void DispatchLatest(Inbox& inbox, const WireHeader& header, ByteView message, int64_t now);
  void PostNewest(Latest& latest, size_t subscription, const std::shared_ptr<Subscription>& s, Bytes message);
  void Post(const std::shared_ptr<Subscription>& subscription, Bytes message);
  bool Ready(const Inbox& inbox) const;
  bool Drain(Inbox& inbox, Source& source, int64_t now);
  void PollSource(const Inbox& inbox, SourceId publisher, Source& source, int64_t now);
  void Count(const Inbox& inbox, Source& source);

  const BusOptions& options_;
  bool two_way_;
  RunLoop& loop_;
  ReceiverCounts& counts_;
  Ask ask_;
  std::map<std::string, Inbox, std::less<>> inboxes_;  // by name on the wire
  Rest rest_;
  bool takes_more_ = true;  // of ordered channels

  // Orders of other threads.
  std::atomic<bool> has_orders_{false};
  std::mutex orders_mutex_;
  std::vector<Addition> additions_;
  Rest added_rest_;
  std::function<void()> when_closed_;
};

}  // namespace plslam::bus
