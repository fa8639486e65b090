// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "tools/doctor/bus_address.h"
#include "tools/doctor/finding.h"

namespace plslam {

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

}  // namespace plslam
