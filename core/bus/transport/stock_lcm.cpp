// SPDX-License-Identifier: BSD-3-Clause
#include "core/bus/transport/stock_lcm.h"

#include <fmt/format.h>
#include <lcm/lcm.h>
#include <poll.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <stdexcept>
#include <string_view>
#include <thread>

#include "core/bus/transport/transport.h"
#include "core/errors/error_text.h"

namespace plslam::bus {
namespace {

/// So few that what is handled is not old, and so many that two of a pair fit in.
constexpr int kWaitingMessages = 4;
constexpr std::string_view kBusOption = "bus.url";

std::string UrlOf(const std::string& url, const std::string& option) {
  const std::string effective = EffectiveUrl(url);
  if (!effective.starts_with("udpm://")) return effective;
  try {
    return WithReceiveBuffer(effective);
  } catch (const std::runtime_error& error) {
    std::string words = error.what();
    if (words.starts_with(kBusOption)) words.replace(0, kBusOption.size(), option);
    throw std::runtime_error(words);
  }
}

}  // namespace

StockLcm::StockLcm(const std::string& url, const std::string& option) : url_(UrlOf(url, option)) {
  errno = 0;
  lcm_ = lcm_create(url_.c_str());
  if (lcm_ != nullptr) return;
  throw std::runtime_error(
      fmt::format("{}: LCM cannot open {}{}", option, url_, errno == 0 ? "" : ": " + ReasonOf(errno)));
}

StockLcm::~StockLcm() { lcm_destroy(lcm_); }

void StockLcm::Subscribe(const std::string& channel, std::function<void(ByteView)> take) {
  const auto& subscription =
      subscriptions_.emplace_back(std::make_unique<Subscription>(Subscription{std::move(take), &failure_}));
  // An exception must not pass through LCM, which is C.
  const auto handler = [](const lcm_recv_buf_t* buffer, const char*, void* user) {
    const auto& self = *static_cast<const Subscription*>(user);
    try {
      self.take({static_cast<const uint8_t*>(buffer->data), buffer->data_size});
    } catch (...) {
      *self.failure = std::current_exception();
    }
  };
  lcm_subscription_t* const made = lcm_subscribe(lcm_, Quoted(channel).c_str(), handler, subscription.get());
  if (made == nullptr) throw std::runtime_error(fmt::format("LCM cannot listen to '{}' at {}", channel, url_));
  lcm_subscription_set_queue_capacity(made, kWaitingMessages);
}

bool StockLcm::Handle(int timeout_ms) {
  const int fd = lcm_get_fileno(lcm_);
  if (fd < 0) {  // tcpq without its relay: LCM tries to connect again within lcm_handle
    std::this_thread::sleep_for(std::chrono::milliseconds(timeout_ms));
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

}  // namespace plslam::bus
