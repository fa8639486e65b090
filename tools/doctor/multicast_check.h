// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "tools/doctor/finding.h"
#include "tools/doctor/socket_check.h"

namespace plslam::doctor {

/// A network device that is there.
struct NetworkDevice {
  std::string name;
  bool up = false;
  bool loopback = false;
  bool multicast = false;
};

/// Returns the device of the route to an IPv4 address from a table in the format of /proc/net/route (the longest prefix
/// that is up, then the lowest metric); empty if there is none.
std::string RouteDevice(const std::string& table, const std::string& address);

/// Returns the problems of route, devices and ttl that keep datagrams of `address` from their readers; empty if there
/// are none. Precondition: kMulticast.
Findings CheckRoute(const BusAddress& address, const std::string& route_device,
                    const std::vector<NetworkDevice>& devices);

/// Checks this host in the same way, and whether a datagram to the group returns to it.
Findings CheckMulticast(const BusAddress& address);

}  // namespace plslam::doctor
