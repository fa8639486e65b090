// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/bus/channels.h"
#include "core/bus/options.h"
#include "core/bus/transport/wire.h"
#include "core/ids/ids.h"

namespace plslam {
class header_t;
}

namespace plslam::bus {

/// Counts of the messages on the bus since start; published in `status_t.counters`.
struct BusCounters {
  int64_t sent = 0;
  int64_t received = 0;
  int64_t lost = 0;                        ///< messages of ordered channels that were missed on the wire
  std::map<std::string, int64_t> lost_of;  ///< the same by channel; only those with losses
  int64_t repaired = 0;                    ///< of those, delivered after all
  int64_t resent = 0;                      ///< own messages, on request
  int64_t rejected = 0;                    ///< malformed, foreign schema, unauthenticated, oversized, replayed
  int64_t unproven = 0;    ///< with a key: of processes that have not proved yet that they are running
  int64_t duplicates = 0;  ///< replayed or sent twice
  int64_t skipped = 0;     ///< of kLatest channels, overtaken by newer ones
};

/// The only interface to LCM. Receives on a separate thread, checks and orders there, and delivers on the thread that
/// calls `Run`, one message at a time: handlers need no locks. No lock of the bus is held while a handler runs.
///
/// Publishing is safe from any thread. An ordered message that cannot be sent at once (a reader is slow and the window
/// is full) makes `Publish` wait, at most `BusOptions::max_wait_ms`; then it is left to repair.
class Bus {
 public:
  /// Throws std::runtime_error with one sentence if the URL, the key file or the history folder is not usable.
  Bus(const BusOptions& options, const std::string& process);
  ~Bus();
  Bus(const Bus&) = delete;
  Bus& operator=(const Bus&) = delete;

  /// Returns the name on the wire of a channel that this process publishes, prefix included.
  std::string WireName(const Channel& channel) const;

  /// Random name of this process start (`header_t.source`).
  SourceId source() const;

  /// Fills in `message.header` (all but `t_ns` and `session`, which the caller sets) and sends. T is the generated type
  /// named in `channel.type`.
  template <class T>
  void Publish(const Channel& channel, T message);

  /// Delivers messages of `channel` from all publishers to `handler` on the thread of `Run`. Ordered channels are
  /// delivered in order for each publisher, from the publisher's oldest kept message on.
  template <class T>
  void Subscribe(const Channel& channel, std::function<void(const T&)> handler);

  /// Subscribes to an ordered channel without repairs and acknowledgements: messages may be missing (pictures). Of a
  /// kLatest channel, messages that wait for the handler are not replaced by newer ones.
  template <class T>
  void SubscribeBestEffort(const Channel& channel, std::function<void(const T&)> handler);

  /// Calls `f` on the thread of `Run`, soon; safe from any thread.
  void Post(std::function<void()> f);

  /// Calls `f` on the thread of `Run` every `period`.
  void Every(std::chrono::milliseconds period, std::function<void()> f);

  /// Calls `f` once on the thread of `Run`, after `delay`.
  void After(std::chrono::milliseconds delay, std::function<void()> f);

  /// Delivers until `Stop` (from any thread or a handler). Returns at once if stopped before.
  void Run();
  void Stop();
  /// Stops when all received, and so acknowledged, messages are handled; receives no more messages of ordered channels.
  void StopWhenHandled();

  /// Returns the number of ordered readers of `channel` that have acknowledged something within the last second.
  int ReaderCount(const Channel& channel) const;

  /// Blocks until every such reader has everything sent, or the time is over. Returns true if they have.
  bool Flush(std::chrono::milliseconds limit);
  /// Like `Flush`, but also waits for readers that have fallen silent: a cable may be out, and after its exit this
  /// process cannot resend.
  bool FlushToSilent(std::chrono::milliseconds limit);
  /// Grows with each new acknowledgement of any reader: a caller that waits for all readers sees whether they progress.
  int64_t acknowledged() const;

  BusCounters counters() const;
  /// Returns one line on messages rejected within the last minute, on other prefixes and on lost packets; empty if there
  /// are none.
  std::string Problems() const;
  /// Whether messages of another key were rejected within the last minute.
  bool hears_other_key() const;

  /// Options as given.
  const BusOptions& options() const;
  /// Largest size of pages and strips now, fingerprint and header included: `max_message_bytes` without the MAC, or one
  /// packet while packets are lost (`MessageSize`).
  int64_t page_bytes() const;
  /// Largest size of any message, independent of the option for pages; `Publish` throws beyond.
  int64_t largest_message_bytes() const;

  /// For assemblers of pages and strips: `take` receives the checked bytes of each message (without MAC) on the
  /// receiving thread; it must be quick and must not publish. kOrdered: in order, repaired and acknowledged, and held
  /// back while `ready` is false (it is polled within milliseconds). kAsItComes: every message, in the order of
  /// arrival, also of kLatest channels. kPaced: the same, acknowledged, so that the publisher is not much ahead of the
  /// reader.
  enum class Reading { kOrdered, kAsItComes, kPaced };
  void SubscribeBytes(const Channel& channel, Reading reading, std::function<bool()> ready,
                      std::function<void(std::span<const uint8_t>)> take);

  /// For recorders, before any other subscription: the raw bytes of every message that no other subscription is for,
  /// on the receiving thread, unchecked.
  void SubscribeRest(std::function<void(std::string_view wire_name, std::span<const uint8_t>)> take);

  /// Counts a message whose content is invalid.
  void CountRejected();
  /// Counts messages of a kLatest channel that an assembler skipped.
  void CountSkipped(int64_t n);

 private:
  using Encode = std::function<int(void* buffer, int size)>;
  using Deliver = std::function<bool(std::span<const uint8_t> message)>;

  void PublishEncoded(const Channel& channel, const char* type, header_t& header,
                      const std::function<int()>& encoded_size, const Encode& encode);
  void SubscribeDecoded(const Channel& channel, const char* type, bool best_effort, Deliver deliver);
  template <class T>
  static Deliver Decoder(std::function<void(const T&)> handler);

  struct Impl;
  std::unique_ptr<Impl> impl_;
};

template <class T>
void Bus::Publish(const Channel& channel, T message) {
  PublishEncoded(
      channel, T::getTypeName(), message.header, [&] { return message.getEncodedSize(); },
      [&](void* buffer, int size) { return message.encode(buffer, 0, size); });
}

template <class T>
Bus::Deliver Bus::Decoder(std::function<void(const T&)> handler) {
  return [handler = std::move(handler)](std::span<const uint8_t> bytes) {
    const std::optional<T> message = Decoded<T>(bytes);
    if (message) handler(*message);
    return message.has_value();
  };
}

template <class T>
void Bus::Subscribe(const Channel& channel, std::function<void(const T&)> handler) {
  SubscribeDecoded(channel, T::getTypeName(), false, Decoder<T>(std::move(handler)));
}

template <class T>
void Bus::SubscribeBestEffort(const Channel& channel, std::function<void(const T&)> handler) {
  SubscribeDecoded(channel, T::getTypeName(), true, Decoder<T>(std::move(handler)));
}

}  // namespace plslam::bus
