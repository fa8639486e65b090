// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "tools/doctor/finding.h"

namespace plslam::doctor {

/// The parts of an LCM URL that the network checks need.
struct BusAddress {
  enum class Kind { kMulticast, kRelay, kOther };
  std::string url;
  Kind kind = Kind::kOther;
  std::string host = "239.255.76.67";  ///< multicast group, or host of the relay
  int port = 7667;
  int ttl = 0;
  /// Value of `recv_buf_size`; 0: not given.
  int receive_buffer = 0;
};

/// `url` as processes take it: empty means LCM_DEFAULT_URL, or LCM's default. Throws std::runtime_error where the
/// port or the ttl is no number.
BusAddress ParseBusAddress(const std::string& url);

/// A UDP socket of this host, as a row of /proc/net/udp has it.
struct UdpSocket {
  int port = 0;
  int64_t inode = 0;
  int64_t drops = 0;  ///< datagrams that found its buffer full, or that its filter does not want
};

std::vector<UdpSocket> ParseUdpSockets(const std::string& table);

/// Checks whether the kernel grants the receive buffer that the bus requests, and whether sockets of the bus have lost
/// datagrams.
/// Returns the number of datagrams that found a full buffer, from the text of /proc/net/snmp; 0 if it is not there.
int64_t ParseBufferErrors(const std::string& table);

Findings CheckReceiveBuffer(const BusAddress& address);

/// kMulticast: checks whether the port can be shared with LCM. kRelay: checks whether an LCM relay answers there.
Findings CheckPort(const BusAddress& address);

}  // namespace plslam::doctor
