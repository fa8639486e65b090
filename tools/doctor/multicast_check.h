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

/// Device of the route to an IPv4 address by a table as /proc/net/route has it (the longest prefix that is up, then
/// the lowest metric); empty where there is none.
std::string RouteDevice(const std::string& table, const std::string& address);

/// What of route, devices and ttl keeps datagrams of `address` from their readers; empty where nothing does.
/// Precondition: kMulticast.
Findings CheckRoute(const BusAddress& address, const std::string& route_device,
                    const std::vector<NetworkDevice>& devices);

/// The same on this host as it is, and whether a datagram to the group comes back to it.
Findings CheckMulticast(const BusAddress& address);

}  // namespace plslam::doctor
