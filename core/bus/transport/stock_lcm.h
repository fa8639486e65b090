// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>
#include <exception>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/bus/transport/long_messages.h"
#include "core/bus/transport/udp_receiver.h"
#include "core/bus/transport/wire.h"
#include "lcmtypes/message_layout.h"

struct _lcm_t;

namespace plslam::bus {

/// LCM as used by other programs: messages as bytes of any length, in parts if they are longer than a datagram.
/// Messages are not repaired, and received ones are not checked (`CheckedMessage`).
///
/// Over udpm:// our own receiver is used (see `UdpReceiver` for the reason); sending, and all other URLs, use LCM.
class StockLcm {
 public:
  /// Empty: LCM_DEFAULT_URL, or LCM's default. Throws std::runtime_error with one sentence that begins with `option`,
  /// the option of the URL.
  StockLcm(const std::string& url, const std::string& option);
  ~StockLcm();
  StockLcm(const StockLcm&) = delete;
  StockLcm& operator=(const StockLcm&) = delete;

  /// Throws the exceptions of the constructor. `take` is called by `Handle`. For a slow reader only the few messages
  /// wait that fit into the socket's buffer.
  void Subscribe(const std::string& channel, std::function<void(ByteView)> take);

  /// Delivers the messages that arrive within this time, after the first `Subscribe`. Returns false at the end of a
  /// log. Exceptions of `take` are passed on.
  bool Handle(int timeout_ms);

  /// Safe from any thread. Returns false if LCM cannot send, as to a relay that has exited.
  bool Publish(const std::string& channel, ByteView bytes);

  /// Messages that lost a part.
  int64_t lost() const { return long_messages_.lost(); }

 private:
  struct Subscription {
    std::string channel;
    std::function<void(ByteView)> take;
    std::exception_ptr* failure = nullptr;
  };

  void SubscribeByLcm(Subscription& subscription);
  bool IsSubscribed(std::string_view channel) const;
  void Deliver(std::string_view channel, ByteView bytes) const;
  void TakeDatagram(const UdpReceiver::Datagram& datagram);

  const std::string option_;
  const std::string url_;
  _lcm_t* lcm_ = nullptr;
  std::exception_ptr failure_;
  std::chrono::steady_clock::time_point tried_at_;
  std::vector<std::unique_ptr<Subscription>> subscriptions_;
  std::optional<UdpReceiver> udp_;
  LongMessages long_messages_;
};

/// Calls `take` with each message on any channel of `url` that arrives within this time, by LCM's own receiver. Throws the
/// exceptions of the constructor of `StockLcm`, and those of `take`.
void ReceiveAll(const std::string& url, const std::string& option, std::chrono::milliseconds time,
                const std::function<void(std::string_view channel, ByteView bytes)>& take);

/// The message of a foreign type that has this layout; nullopt where its bytes are not one, or lie about their sizes.
template <class Message>
std::optional<Message> CheckedMessage(const MessageLayout& layout, ByteView bytes) {
  return MessageLength(layout, bytes) ? Decoded<Message>(bytes) : std::nullopt;
}

}  // namespace plslam::bus
