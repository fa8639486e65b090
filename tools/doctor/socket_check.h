// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "tools/doctor/finding.h"

namespace plslam::doctor {

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

/// A UDP socket of this host, as a row of /proc/net/udp has it.
struct UdpSocket {
  int port = 0;
  int64_t inode = 0;
  int64_t drops = 0;  ///< datagrams that found its buffer full
};

std::vector<UdpSocket> ParseUdpSockets(const std::string& table);

/// Whether the kernel grants the receive buffer that the bus asks for, and whether sockets of the bus have lost
/// datagrams.
Findings CheckReceiveBuffer(const BusAddress& address);

/// kMulticast: whether the port can be shared with LCM. kRelay: whether an LCM relay answers there.
Findings CheckPort(const BusAddress& address);

}  // namespace plslam::doctor
