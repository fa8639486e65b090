// SPDX-License-Identifier: BSD-3-Clause
#include "core/bus/transport/stock_lcm.h"

#include <fmt/format.h>
#include <lcm/lcm.h>
#include <poll.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <set>
#include <stdexcept>
#include <string_view>
#include <thread>

#include "core/bus/transport/transport.h"
#include "core/errors/error_text.h"

namespace plslam::bus {
namespace {

/// Length of LCM's queue: short enough that handled messages are recent, and long enough for both images of a pair.
constexpr int kWaitingMessages = 4;
constexpr std::string_view kMulticast = "udpm://";
constexpr int kBatch = 64;
/// LCM prints a few words on each failure to connect.
constexpr std::chrono::seconds kReconnect{5};
constexpr std::string_view kBusOption = "bus.url";

/// Calls `f` and renames the option of the bus URL in its errors to `option`.
template <class F>
auto Named(const std::string& option, const F& f) {
  try {
    return f();
  } catch (const std::runtime_error& error) {
    std::string words = error.what();
    if (words.starts_with(kBusOption)) words.replace(0, kBusOption.size(), option);
    throw std::runtime_error(words);
  }
}

std::string UrlOf(const std::string& url, const std::string& option) {
  std::string effective = EffectiveUrl(url);
  if (!effective.starts_with(kMulticast)) return effective;
  std::string with_buffer = Named(option, [&] { return WithReceiveBuffer(effective); });
  const std::string why_not = WhyNoGroup(ParseUdpGroup(effective).address);
  if (!why_not.empty()) throw std::runtime_error(fmt::format("{}: {}: {}", option, effective, why_not));
  return with_buffer;
}

}  // namespace

StockLcm::StockLcm(const std::string& url, const std::string& option)
    : option_(option),
      url_(UrlOf(url, option)),
      long_messages_([this](std::string_view channel) { return IsSubscribed(channel); }) {
  errno = 0;
  lcm_ = lcm_create(url_.c_str());
  if (lcm_ != nullptr) return;
  throw std::runtime_error(
      fmt::format("{}: LCM cannot open {}{}", option, url_, errno == 0 ? "" : ": " + ReasonOf(errno)));
}

StockLcm::~StockLcm() { lcm_destroy(lcm_); }

void StockLcm::Subscribe(const std::string& channel, std::function<void(ByteView)> take) {
  Subscription& subscription =
      *subscriptions_.emplace_back(std::make_unique<Subscription>(Subscription{channel, std::move(take), &failure_}));
  if (!url_.starts_with(kMulticast)) return SubscribeByLcm(subscription);
  if (!udp_) Named(option_, [&] { udp_.emplace(url_); });
  std::set<std::string, std::less<>> names;
  for (const auto& each : subscriptions_) names.insert(each->channel);
  FilterDatagrams(udp_->fd(), names);
}

void StockLcm::SubscribeByLcm(Subscription& subscription) {
  // An exception must not pass through LCM, which is C.
  const auto handler = [](const lcm_recv_buf_t* buffer, const char*, void* user) {
    const auto& self = *static_cast<const Subscription*>(user);
    try {
      self.take({static_cast<const uint8_t*>(buffer->data), buffer->data_size});
    } catch (...) {
      *self.failure = std::current_exception();
    }
  };
  lcm_subscription_t* const made = lcm_subscribe(lcm_, Quoted(subscription.channel).c_str(), handler, &subscription);
  if (made == nullptr) {
    throw std::runtime_error(fmt::format("LCM cannot listen to '{}' at {}", subscription.channel, url_));
  }
  lcm_subscription_set_queue_capacity(made, kWaitingMessages);
}

bool StockLcm::IsSubscribed(std::string_view channel) const {
  return std::any_of(subscriptions_.begin(), subscriptions_.end(),
                     [&](const auto& s) { return s->channel == channel; });
}

void StockLcm::Deliver(std::string_view channel, ByteView bytes) const {
  for (const auto& subscription : subscriptions_) {
    if (subscription->channel == channel) subscription->take(bytes);
  }
}

void StockLcm::TakeDatagram(const UdpReceiver::Datagram& datagram) {
  std::string_view channel;
  ByteView bytes;
  if (ParsePacket(datagram.bytes, &channel, &bytes)) return Deliver(channel, bytes);
  const std::optional<MessagePart> part = ParsePart(datagram.bytes);
  if (!part) return;
  if (const auto message = long_messages_.Add(datagram.sender, *part)) Deliver(message->channel, message->bytes);
}

bool StockLcm::Handle(int timeout_ms) {
  if (subscriptions_.empty()) throw std::logic_error("StockLcm::Handle without a subscription");
  if (udp_) {
    pollfd readable = {udp_->fd(), POLLIN, 0};
    if (poll(&readable, 1, timeout_ms) <= 0) return true;
    for (int i = 0; i < kBatch; ++i) {
      const auto datagram = udp_->ReceiveDatagram();
      if (!datagram) break;
      TakeDatagram(*datagram);
    }
    return true;
  }
  const int fd = lcm_get_fileno(lcm_);
  if (fd < 0) {  // tcpq without its relay: LCM tries to connect again within lcm_handle
    std::this_thread::sleep_for(std::chrono::milliseconds(timeout_ms));
    const auto now = std::chrono::steady_clock::now();
    if (now - tried_at_ < kReconnect) return true;
    tried_at_ = now;
    lcm_handle(lcm_);
    return true;
  }
  pollfd readable = {fd, POLLIN, 0};
  if (poll(&readable, 1, timeout_ms) <= 0) return true;
  const bool handled = lcm_handle(lcm_) == 0;
  if (failure_) std::rethrow_exception(std::exchange(failure_, nullptr));
  return handled || !url_.starts_with("file://");
}

bool StockLcm::Publish(const std::string& channel, ByteView bytes) {
  return lcm_publish(lcm_, channel.c_str(), bytes.data(), static_cast<unsigned>(bytes.size())) == 0;
}

void ReceiveAll(const std::string& url, const std::string& option, std::chrono::milliseconds time,
                const std::function<void(std::string_view, ByteView)>& take) {
  struct Listener {
    const std::function<void(std::string_view, ByteView)>& take;
    std::exception_ptr failure;
  } listener{take, nullptr};
  const std::string effective = UrlOf(url, option);
  const std::unique_ptr<_lcm_t, void (*)(_lcm_t*)> lcm(lcm_create(effective.c_str()), lcm_destroy);
  if (lcm == nullptr) throw std::runtime_error(fmt::format("{}: LCM cannot open {}", option, effective));
  const auto handler = [](const lcm_recv_buf_t* buffer, const char* channel, void* user) {
    auto& self = *static_cast<Listener*>(user);
    try {
      self.take(channel, {static_cast<const uint8_t*>(buffer->data), buffer->data_size});
    } catch (...) {
      self.failure = std::current_exception();
    }
  };
  if (lcm_subscribe(lcm.get(), ".*", handler, &listener) == nullptr) {
    throw std::runtime_error(fmt::format("{}: LCM cannot listen at {}", option, effective));
  }
  const auto end = std::chrono::steady_clock::now() + time;
  while (listener.failure == nullptr) {
    const auto left = std::chrono::ceil<std::chrono::milliseconds>(end - std::chrono::steady_clock::now());
    if (left.count() <= 0 || lcm_handle_timeout(lcm.get(), static_cast<int>(left.count())) < 0) break;
  }
  if (listener.failure != nullptr) std::rethrow_exception(listener.failure);
}

}  // namespace plslam::bus
