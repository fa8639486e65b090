// SPDX-License-Identifier: BSD-3-Clause
#include "tools/launch/run_bus.h"

#include <netinet/in.h>
#include <unistd.h>

#include <sys/socket.h>
#include <stdexcept>

#include <fmt/format.h>

#include "core/bus/transport/transport.h"
#include "core/errors/log.h"

namespace plslam::launcher {
namespace {

constexpr char kGroup[] = "239.255.76.67";

}  // namespace

PrivatePort::PrivatePort() : socket_(socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0)) {
  sockaddr_in address{};  // any host, any port
  address.sin_family = AF_INET;
  socklen_t size = sizeof address;
  auto* bare = reinterpret_cast<sockaddr*>(&address);
  if (bind(socket_, bare, size) != 0 || getsockname(socket_, bare, &size) != 0) {
    close(socket_);
    throw std::runtime_error("no free UDP port");
  }
  port_ = ntohs(address.sin_port);
  // Set only now: the port was assigned exclusively, and from here on LCM may share it. Its traffic does not accumulate
  // here, since this socket receives no multicast.
  const int yes = 1, no = 0;
  setsockopt(socket_, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
  setsockopt(socket_, IPPROTO_IP, IP_MULTICAST_ALL, &no, sizeof no);
}

PrivatePort::~PrivatePort() { close(socket_); }

std::string PrivatePort::Url() const { return fmt::format("udpm://{}:{}?ttl=0", kGroup, port_); }

RunBus::RunBus(const std::string& url) : url_(url) {
  if (!url_.empty()) return;
  port_ = std::make_unique<PrivatePort>();
  url_ = port_->Url();
  std::string reason;
  if (bus::MulticastWorks(url_, &reason)) return;
  LogWarning("no multicast on this machine ({}): messages go through a relay (tcpq)", reason);
  port_.reset();
  relay_ = std::make_unique<BackgroundRelay>();
  url_ = relay_->url();
}

}  // namespace plslam::launcher
