// SPDX-License-Identifier: BSD-3-Clause
#include <array>
#include <cerrno>
#include <cstring>
#include <stdexcept>
#include <string>

#include <arpa/inet.h>
#include <fmt/format.h>
#include <netinet/in.h>
#include <poll.h>
#include <sodium.h>
#include <sys/socket.h>
#include <unistd.h>

#include "core/bus/transport/transport.h"
#include "core/errors/error_text.h"

namespace plslam::bus {
namespace {

/// Returns the group of a udpm URL, LCM's default for an empty one; empty for other URLs.
std::string GroupOf(const std::string& url) {
  try {
    return url.empty() ? UdpGroup().address : ParseUdpGroup(url).address;
  } catch (const std::runtime_error&) {
    return "";
  }
}

class Socket {
 public:
  Socket() : fd_(socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0)) {}
  ~Socket() { close(fd_); }
  Socket(const Socket&) = delete;
  Socket& operator=(const Socket&) = delete;
  int fd() const { return fd_; }

 private:
  int fd_;
};

/// Joins the group on a separate port, so that the probe does not reach other LCM traffic.
bool Join(const Socket& socket, in_addr group, sockaddr_in& name) {
  name = {};
  name.sin_family = AF_INET;
  socklen_t length = sizeof(name);
  ip_mreq membership{};
  membership.imr_multiaddr = group;
  const unsigned char ttl = 0;
  const bool ok = bind(socket.fd(), reinterpret_cast<const sockaddr*>(&name), sizeof(name)) == 0 &&
                  getsockname(socket.fd(), reinterpret_cast<sockaddr*>(&name), &length) == 0 &&
                  setsockopt(socket.fd(), IPPROTO_IP, IP_ADD_MEMBERSHIP, &membership, sizeof(membership)) == 0 &&
                  setsockopt(socket.fd(), IPPROTO_IP, IP_MULTICAST_TTL, &ttl, sizeof(ttl)) == 0;
  name.sin_addr = group;
  return ok;
}

}  // namespace

std::string NoRouteToGroup(const std::string& group, int error_number) {
  return fmt::format("this host has no route to the multicast group {}{}", group,
                     error_number == 0 ? "" : fmt::format(" ({})", std::strerror(error_number)));
}

std::string WhyNoGroup(const std::string& address) {
  in_addr group{};
  if (inet_pton(AF_INET, address.c_str(), &group) == 1 && IN_MULTICAST(ntohl(group.s_addr))) return "";
  return fmt::format("'{}' is not a multicast group (224.0.0.0 to 239.255.255.255)", Shown(address));
}

bool MulticastWorks(const std::string& url, std::string* reason) {
  const auto fail = [&](const std::string& why) {
    if (reason != nullptr) *reason = why;
    return false;
  };
  const std::string group_text = GroupOf(url);
  const std::string why_no_group = WhyNoGroup(group_text);
  if (!why_no_group.empty()) return fail(url + ": " + why_no_group);
  in_addr group{};
  inet_pton(AF_INET, group_text.c_str(), &group);
  const Socket socket;
  sockaddr_in name{};
  if (socket.fd() < 0 || !Join(socket, group, name)) {
    return fail(NoRouteToGroup(group_text, errno));
  }
  std::array<uint8_t, 16> probe{};
  randombytes_buf(probe.data(), probe.size());
  for (int attempt = 0; attempt < 3; ++attempt) {
    if (sendto(socket.fd(), probe.data(), probe.size(), 0, reinterpret_cast<const sockaddr*>(&name), sizeof(name)) <
        0) {
      return fail(NoRouteToGroup(group_text, errno));
    }
    pollfd readable = {socket.fd(), POLLIN, 0};
    while (poll(&readable, 1, 100) > 0) {
      std::array<uint8_t, 16> answer{};
      const ssize_t n = recv(socket.fd(), answer.data(), answer.size(), 0);
      if (n == static_cast<ssize_t>(probe.size()) && answer == probe) return true;
    }
  }
  return fail("datagrams to the multicast group " + group_text + " do not come back to this machine");
}

}  // namespace plslam::bus
