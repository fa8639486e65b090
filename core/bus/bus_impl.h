// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <atomic>
#include <condition_variable>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <random>
#include <set>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "core/bus/bus.h"
#include "core/bus/delivery/ordered_reader.h"
#include "core/bus/delivery/ordered_writer.h"
#include "core/bus/run_loop.h"
#include "core/bus/transport/authenticator.h"
#include "core/bus/transport/live_peers.h"
#include "core/bus/transport/rejections.h"
#include "core/bus/transport/transport.h"

namespace plslam::bus {

inline constexpr int64_t kMs = 1'000'000;
/// For how long a reader or publisher that is silent keeps its place.
inline constexpr int64_t kRemembered = 60'000 * kMs;

/// One Subscribe call.
struct Subscription {
  enum class Kind { kOrdered, kAsItComes, kNewest, kOrderedBytes, kBytes, kPacedBytes };
  Kind kind;
  std::function<bool(ByteView)> deliver;  ///< on the thread of Run, or (bytes) on the receiving thread
  std::function<bool()> ready;            ///< kOrderedBytes: whether it can take one now
};

/// The newest message of one publisher of a kLatest channel that waits for one handler.
struct LatestSlot {
  std::mutex mutex;
  Bytes newest;  // nullptr: none waits
};

/// Everything of one subscribed channel.
struct Inbox {
  Channel channel;
  const MessageLayout* layout = nullptr;
  std::vector<std::shared_ptr<Subscription>> subscriptions;
  bool ordered = false;  // somebody wants order and repair
  std::map<int64_t, OrderedReader> readers;
  struct Latest {
    int64_t seq = -1;
    int64_t heard = 0;
    std::vector<std::shared_ptr<LatestSlot>> slots;  // one for each subscription
  };
  std::map<int64_t, Latest> latest;
  bool paced = false;
  std::map<int64_t, int64_t> unacknowledged;  // cost by publisher, where paced
  int64_t next_hello = 0;
};

/// Channels of big unordered messages whose publisher minds what its readers have taken.
inline bool IsPaced(const Channel& channel) { return channel.name == kStereoFrameLive.name; }

/// Channels whose publisher has all the time that its readers need, as long as they get on.
inline bool IsInLockstep(const Channel& channel) { return channel.name == kStereoFrame.name; }

/// One published channel.
struct Outbox {
  Channel channel;
  std::string wire_name;
  std::string map_name;      // kToMap: where it goes too; empty: nowhere
  std::mutex publish_mutex;  // one message at a time, from its number to the wire
  int64_t seq = 0;
  int64_t sent = 0;                       // one past the newest that has been handed to LCM
  std::unique_ptr<OrderedWriter> writer;  // ordered and paced channels
};

/// Readers that say "I read this channel" on the wire, whether we publish it (yet) or not.
struct Hello {
  int64_t heard = 0;
  int64_t window = 0;
};
using Hellos = std::map<int64_t, Hello>;

/// One mutex guards all state; nothing is sent and no handler of the user runs while it is held.
struct Bus::Impl {
  Impl(const BusOptions& options, std::string process);
  ~Impl();

  // publish.cpp
  Outbox& OutboxOf(const Channel& channel);
  int ReaderCount(const Channel& channel) const;
  void WaitForWindow(Outbox& outbox, size_t bytes);
  /// Nanoseconds without a word of theirs for which those are waited for whose window is full.
  int64_t PatienceWithReaders(const Channel& channel) const;
  bool Flush(std::chrono::milliseconds limit, bool to_silent = false);
  std::string HistoryPath(const Channel& channel);
  Bytes Sealed(const std::string& wire_name, int64_t seq, header_t& header, const std::function<int()>& size,
               const Encode& encode) const;

  // receive.cpp
  void Subscribe(const Channel& channel, const char* type, std::shared_ptr<Subscription> subscription);
  void Listen(const std::string& wire_name, const Channel& channel, const MessageLayout* layout,
              const std::shared_ptr<Subscription>& subscription);
  void OnDatagram(std::string_view wire_name, ByteView bytes);
  void MayReceive();
  void ReceiveLoop();
  void EndReaders();

  static int64_t Now();
  const std::string& MapPrefix() const { return options.map_prefix.empty() ? options.prefix : options.map_prefix; }
  /// Of where channels of that scope are published, and requests and announcements about them.
  const std::string& PrefixOf(Scope scope) const { return scope == Scope::kMap ? MapPrefix() : options.prefix; }
  /// Where the channel is published, and (all but kFromMap) read.
  std::string WireName(const Channel& channel) const;
  /// The same under the map's prefix; empty where that is the same name.
  std::string NameForMap(const Channel& channel) const;
  /// Whether `wire_name` is the channel under the one or the other prefix.
  bool IsNamed(std::string_view wire_name, const Channel& channel) const;

  BusOptions options;
  std::string process;
  int64_t source = 0;
  Authenticator authenticator;
  Transport transport;
  RunLoop loop;

  mutable std::mutex mutex;
  std::condition_variable acknowledged;                                  // with `mutex`: a reader's word has come
  std::map<std::string, std::unique_ptr<Outbox>, std::less<>> outboxes;  // by channel name
  std::map<std::string, Hellos, std::less<>> hellos;     // by channel name, of all channels of the table
  std::map<std::string, Inbox, std::less<>> inboxes;     // by name on the wire
  std::function<void(std::string_view, ByteView)> rest;  // takes what no inbox is for
  bool takes_more = true;                                // of ordered channels
  std::atomic<bool> stopped = false;                     // the process ends
  std::string history_folder;
  bool temporary_folder = false;
  BusCounters counts;
  Rejections rejections;
  LivePeers peers;                    // with a key
  std::atomic<int64_t> nonsense = 0;  // counted by assemblers, on whatever thread
  std::atomic<int64_t> passed_over = 0;
  int64_t given_lost = 0;  // of readers dropped since
  int64_t given_repaired = 0;

 private:
  struct Outgoing {
    std::string wire_name;
    Bytes bytes;
  };

  bool Drop();

  // check.cpp
  void Reject(Rejection why, std::string_view wire_name, int64_t now);
  std::optional<Rejection> WhyNot(std::string_view wire_name, const MessageLayout& layout, ByteView bytes,
                                  size_t* length) const;
  /// Checked message without its MAC; empty where it is rejected.
  ByteView Checked(std::string_view wire_name, const MessageLayout& layout, ByteView bytes, int64_t now);
  bool Lives(std::string_view wire_name, ByteView message, int64_t now);
  void NoticePrefix(std::string_view wire_name, int64_t now);

  void Dispatch(Inbox& inbox, const WireHeader& header, ByteView message, int64_t now);
  void DispatchPaced(Inbox& inbox, const WireHeader& header, ByteView message);
  void DispatchOrdered(Inbox& inbox, const WireHeader& header, ByteView message, int64_t now);
  void DispatchLatest(Inbox& inbox, const WireHeader& header, ByteView message, int64_t now);
  void PostNewest(Inbox::Latest& latest, size_t subscription, const std::shared_ptr<Subscription>& s, Bytes message);
  void Deliver(const std::shared_ptr<Subscription>& subscription, Bytes message);
  OrderedReader* ReaderOf(Inbox& inbox, int64_t source, int64_t now);
  bool Ready(const Inbox& inbox) const;
  bool Drain(Inbox& inbox, OrderedReader& reader, int64_t now);

  // control.cpp
  void OnHello(const Channel& channel, int64_t reader, Hello hello);
  void OnRepairRequest(std::string_view wire_name, ByteView message, int64_t now);
  void OnAnnounce(std::string_view wire_name, ByteView message, int64_t now);
  bool IsAbout(const Channel& channel, std::string_view wire_name, const Channel& control) const;
  void PollReaders(int64_t now, int64_t& next);
  void PollWriters(int64_t now, int64_t& next);
  void Announce(Outbox& outbox);
  void Request(const Inbox& inbox, int64_t publisher, const OrderedReader::Request& request);
  void Greet(int64_t peer, bool question);
  void OnGreeting(int64_t peer, int64_t addressee, int64_t kind);
  template <class T>
  void SendControl(const Channel& channel, Scope scope, T message);
  void SendOutgoing();

  const MessageLayout* request_layout_ = nullptr;
  const MessageLayout* announce_layout_ = nullptr;
  std::map<std::string, int64_t, std::less<>> control_seq_;
  std::mt19937_64 drop_random_;
  std::vector<Outgoing> outgoing_;  // of the receiving thread; sent after `mutex` is released
  int64_t next_poll_ = 0;
  std::atomic<int64_t> wake_time_ = 0;
  std::atomic<bool> stopping_ = false;
  /// A log that is read does not wait for subscriptions: it is begun when they have been made, with `Run`.
  std::atomic<bool> may_receive{false};
  std::thread receiver_;

  friend class Bus;
};

}  // namespace plslam::bus
