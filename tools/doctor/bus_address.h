// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

namespace plslam {

/// What an LCM URL says, as far as a check of the network needs it.
struct BusAddress {
  enum class Kind { kMulticast, kRelay, kOther };
  std::string url;
  Kind kind = Kind::kOther;
  std::string host = "239.255.76.67";  ///< multicast group, or host of the relay
  int port = 7667;
  int ttl = 0;
  /// Value of `recv_buf_size`; 0: not said.
  int receive_buffer = 0;
};

/// `url` as processes take it: empty means LCM_DEFAULT_URL, or LCM's default. Throws std::runtime_error where the
/// port or the ttl is no number.
BusAddress ParseBusAddress(const std::string& url);

}  // namespace plslam
