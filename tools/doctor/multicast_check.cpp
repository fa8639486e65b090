// SPDX-License-Identifier: BSD-3-Clause
#include "tools/doctor/multicast_check.h"

#include <algorithm>
#include <cstdint>
#include <fstream>
#include <iterator>
#include <sstream>
#include <tuple>

#include <arpa/inet.h>
#include <fmt/format.h>
#include <ifaddrs.h>
#include <net/if.h>

#include "core/bus/transport/transport.h"

namespace plslam::doctor {
namespace {

constexpr char kCheck[] = "multicast";
constexpr char kRelayInstead[] = "plslam relay --port 7700 &   # and --url tcpq://127.0.0.1:7700 for every process";

const NetworkDevice* Find(const std::vector<NetworkDevice>& devices, const std::string& name) {
  const auto it = std::find_if(devices.begin(), devices.end(), [&](const auto& d) { return d.name == name; });
  return it == devices.end() ? nullptr : &*it;
}

/// Returns a device that reaches other hosts, or else nullptr.
const NetworkDevice* Outward(const std::vector<NetworkDevice>& devices) {
  const auto it =
      std::find_if(devices.begin(), devices.end(), [](const auto& d) { return d.up && d.multicast && !d.loopback; });
  return it == devices.end() ? nullptr : &*it;
}

/// Makes the loopback device carry multicast: it must be up, allow it, and be where the route leads.
std::string RouteOverLoopback() {
  return AsRoot(bus::kMulticastOverLoopback[0]) + " && " + AsRoot(bus::kMulticastOverLoopback[1]);
}

std::string RouteFor(const BusAddress& address, const std::vector<NetworkDevice>& devices) {
  const NetworkDevice* outward = Outward(devices);
  if (address.ttl == 0 || outward == nullptr) return RouteOverLoopback();
  return AsRoot("ip route replace 224.0.0.0/4 dev " + outward->name);
}

std::vector<NetworkDevice> Devices() {
  std::vector<NetworkDevice> devices;
  ifaddrs* list = nullptr;
  if (getifaddrs(&list) != 0) return devices;
  for (const ifaddrs* i = list; i != nullptr; i = i->ifa_next) {
    if (Find(devices, i->ifa_name) != nullptr) continue;
    devices.push_back({i->ifa_name, (i->ifa_flags & IFF_UP) != 0, (i->ifa_flags & IFF_LOOPBACK) != 0,
                       (i->ifa_flags & IFF_MULTICAST) != 0});
  }
  freeifaddrs(list);
  return devices;
}

std::string RouteTable() {
  std::ifstream file("/proc/net/route");
  return {std::istreambuf_iterator<char>(file), {}};
}

}  // namespace

std::string RouteDevice(const std::string& table, const std::string& address) {
  in_addr wanted{};
  if (inet_pton(AF_INET, address.c_str(), &wanted) != 1) return "";
  std::istringstream lines(table);
  std::string line, best;
  std::getline(lines, line);  // names of the columns
  std::tuple<uint32_t, int64_t> best_rank{0, 0};
  while (std::getline(lines, line)) {
    std::istringstream columns(line);
    std::string device;
    uint32_t destination = 0, gateway = 0, flags = 0, mask = 0;
    int64_t references = 0, use = 0, metric = 0;
    columns >> device >> std::hex >> destination >> gateway >> flags >> std::dec >> references >> use >> metric >>
        std::hex >> mask;
    constexpr uint32_t kUp = 1, kReject = 0x200;
    if (!columns || (flags & kUp) == 0 || (flags & kReject) != 0 || (wanted.s_addr & mask) != destination) continue;
    // Masks are in network order: turned round, the longer prefix is the larger number.
    const std::tuple<uint32_t, int64_t> rank{ntohl(mask), -metric};
    if (!best.empty() && rank <= best_rank) continue;
    best = device;
    best_rank = rank;
  }
  return best;
}

Findings CheckRoute(const BusAddress& address, const std::string& route_device,
                    const std::vector<NetworkDevice>& devices) {
  if (route_device.empty()) {
    return {Problem(kCheck, bus::NoRouteToGroup(address.host), RouteFor(address, devices))};
  }
  const NetworkDevice* device = Find(devices, route_device);
  if (device == nullptr || !device->up) {
    return {Problem(kCheck, fmt::format("the route to {} uses {}, which is down", address.host, route_device),
                    AsRoot("ip link set " + route_device + " up"))};
  }
  if (address.ttl > 0 && device->loopback) {
    return {Problem(kCheck,
                    fmt::format("ttl={} should reach other machines, but the route to {} uses {}, which reaches none",
                                address.ttl, address.host, route_device),
                    Outward(devices) == nullptr ? "ip link   # no network device of this host reaches other machines"
                                                : RouteFor(address, devices))};
  }
  if (!device->multicast) {
    const Finding finding = Problem(
        kCheck,
        fmt::format("multicast is off on the device {}, which the route to {} uses", route_device, address.host),
        AsRoot("ip link set " + route_device + " multicast on"));
    // The loopback device carries multicast without the flag; some programs check the flag.
    if (!device->loopback) return {finding};
  }
  return {};
}

Findings CheckMulticast(const BusAddress& address) {
  if (const std::string why = bus::WhyNoGroup(address.host); !why.empty()) {
    return {Problem(kCheck, why,
                    fmt::format("export LCM_DEFAULT_URL=udpm://239.255.76.67:{}?ttl={}", address.port, address.ttl))};
  }
  const std::string device = RouteDevice(RouteTable(), address.host);
  Findings findings = CheckRoute(address, device, Devices());
  std::string reason;
  if (!findings.empty()) return findings;
  if (!bus::MulticastWorks(address.url, &reason)) return {Problem(kCheck, reason, kRelayInstead)};
  const char* reach = address.ttl == 0   ? "they stay on this machine"
                      : address.ttl == 1 ? "they reach the local network"
                                         : "routers that support multicast forward them";
  return {Good(kCheck, fmt::format("datagrams to {} leave over {} and come back; with ttl={} {}", address.host,
                                   device, address.ttl, reach))};
}

}  // namespace plslam::doctor
