// SPDX-License-Identifier: BSD-3-Clause
#include "tools/doctor/bus_address.h"

#include <fmt/format.h>

#include <charconv>
#include <stdexcept>
#include <string_view>

#include "core/bus/transport/transport.h"

namespace plslam {
namespace {

int Number(const std::string& url, std::string_view text, int min, int max) {
  int value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size() || value < min || value > max) {
    throw std::runtime_error(fmt::format("bus.url: {}: '{}' is no number within {} to {}", url, text, min, max));
  }
  return value;
}

/// Value of `key` among the parameters behind '?', which '&' parts; empty where it is not there.
std::string_view Parameter(std::string_view parameters, std::string_view key) {
  while (!parameters.empty()) {
    const std::string_view one = parameters.substr(0, parameters.find('&'));
    parameters.remove_prefix(std::min(parameters.size(), one.size() + 1));
    if (one.starts_with(key) && one.size() > key.size() && one[key.size()] == '=') return one.substr(key.size() + 1);
  }
  return {};
}

}  // namespace

BusAddress ParseBusAddress(const std::string& url) {
  BusAddress address;
  address.url = bus::EffectiveUrl(url);
  std::string_view rest = address.url;
  if (rest.starts_with("udpm://")) address.kind = BusAddress::Kind::kMulticast;
  if (rest.starts_with("tcpq://")) address.kind = BusAddress::Kind::kRelay;
  if (address.kind == BusAddress::Kind::kOther) return address;
  if (address.kind == BusAddress::Kind::kRelay) {
    address.host = "127.0.0.1";
    address.port = 7700;
  }
  rest.remove_prefix(std::string_view("udpm://").size());
  const size_t question = rest.find('?');
  const std::string_view network = rest.substr(0, question);
  const std::string_view parameters = question == std::string_view::npos ? "" : rest.substr(question + 1);
  const size_t colon = network.find(':');
  if (!network.substr(0, colon).empty()) address.host = network.substr(0, colon);
  if (colon != std::string_view::npos) address.port = Number(address.url, network.substr(colon + 1), 1, 65535);
  if (const auto ttl = Parameter(parameters, "ttl"); !ttl.empty()) address.ttl = Number(address.url, ttl, 0, 255);
  if (const auto size = Parameter(parameters, "recv_buf_size"); !size.empty()) {
    address.receive_buffer = Number(address.url, size, 1, 1 << 30);
  }
  return address;
}

}  // namespace plslam
