// SPDX-License-Identifier: BSD-3-Clause
#include "tools/launch/relay/tcpq_relay.h"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <stdexcept>
#include <vector>

#include <arpa/inet.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/eventfd.h>
#include <sys/socket.h>
#include <unistd.h>

#include "tools/launch/relay/tcpq_client.h"

namespace plslam::bus {
namespace {

int ListenOn(const std::string& address, int& port) {
  const std::string where = "relay: " + address + ":" + std::to_string(port);
  sockaddr_in name{};
  name.sin_family = AF_INET;
  name.sin_port = htons(static_cast<uint16_t>(port));
  if (port < 0 || port > 65535 || inet_pton(AF_INET, address.c_str(), &name.sin_addr) != 1) {
    throw std::runtime_error(where + " is not an IPv4 address and port");
  }
  const int fd = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  const int on = 1;
  socklen_t length = sizeof(name);
  const bool ok = fd >= 0 && setsockopt(fd, SOL_SOCKET, SO_REUSEADDR, &on, sizeof(on)) == 0 &&
                  bind(fd, reinterpret_cast<const sockaddr*>(&name), sizeof(name)) == 0 && listen(fd, 64) == 0 &&
                  getsockname(fd, reinterpret_cast<sockaddr*>(&name), &length) == 0;
  if (!ok) {
    const std::string why = std::strerror(errno);
    if (fd >= 0) close(fd);
    throw std::runtime_error(where + ": cannot listen there: " + why);
  }
  port = ntohs(name.sin_port);
  return fd;
}

}  // namespace

struct TcpqRelay::Impl {
  void Accept();
  void Relay(const std::vector<TcpqClient::Publication>& published);
  bool Serve(TcpqClient& client, short events);
  bool Congested() const;

  int listen_fd = -1;
  std::vector<std::unique_ptr<TcpqClient>> clients;
  std::atomic<int64_t> connected = 0;
  std::atomic<int64_t> relayed = 0;
  std::atomic<int64_t> dropped = 0;
  std::atomic<int64_t> malformed = 0;
  std::atomic<bool> stopping = false;
};

TcpqRelay::TcpqRelay(int port, const std::string& address)
    : address_(address), port_(port), impl_(std::make_unique<Impl>()) {
  impl_->listen_fd = ListenOn(address, port_);
  wake_fd_ = eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK);
}

TcpqRelay::~TcpqRelay() {
  close(impl_->listen_fd);
  close(wake_fd_);
}

std::string TcpqRelay::url() const { return "tcpq://" + address_ + ":" + std::to_string(port_); }

void TcpqRelay::Stop() {
  impl_->stopping = true;
  const uint64_t one = 1;
  if (write(wake_fd_, &one, sizeof(one)) < 0) return;  // full: it wakes all the same
}

TcpqRelay::Counters TcpqRelay::counters() const {
  return {impl_->connected, impl_->relayed, impl_->dropped, impl_->malformed};
}

void TcpqRelay::Impl::Accept() {
  const int fd = accept4(listen_fd, nullptr, nullptr, SOCK_CLOEXEC | SOCK_NONBLOCK);
  if (fd < 0) return;
  if (clients.size() >= kMaxClients) {
    close(fd);
    return;
  }
  clients.push_back(std::make_unique<TcpqClient>(fd));
}

bool TcpqRelay::Impl::Congested() const {
  return std::any_of(clients.begin(), clients.end(), [](const auto& client) { return client->Congests(); });
}

void TcpqRelay::Impl::Relay(const std::vector<TcpqClient::Publication>& published) {
  for (const TcpqClient::Publication& publication : published) {
    ++relayed;
    for (const auto& client : clients) {
      if (client->Wants(publication.channel)) dropped += client->Queue(publication.packet);
    }
  }
}

/// Returns false if the connection has ended.
bool TcpqRelay::Impl::Serve(TcpqClient& client, short events) {
  if ((events & POLLIN) != 0) {
    std::vector<TcpqClient::Publication> published;
    const bool open = client.Read(published);
    Relay(published);
    malformed += client.malformed() ? 1 : 0;
    if (!open) return false;
  }
  return (events & (POLLERR | POLLHUP | POLLNVAL)) == 0;
}

void TcpqRelay::Run() {
  static constexpr int kLookAgain_ms = 100;
  std::vector<pollfd> fds;
  while (!impl_->stopping) {
    auto& clients = impl_->clients;
    const bool congested = impl_->Congested();
    fds.assign({{wake_fd_, POLLIN, 0}, {impl_->listen_fd, POLLIN, 0}});
    for (const auto& client : clients) {
      const int events = (congested ? 0 : POLLIN) | (client->HasOutput() ? POLLOUT : 0);
      fds.push_back({client->fd(), static_cast<short>(events), 0});
    }
    poll(fds.data(), fds.size(), congested ? kLookAgain_ms : -1);

    std::vector<const TcpqClient*> ended;
    const size_t n = clients.size();
    for (size_t i = 0; i < n; ++i) {
      if (!impl_->Serve(*clients[i], fds[i + 2].revents)) ended.push_back(clients[i].get());
    }
    const auto now = TcpqClient::Clock::now();
    for (const auto& client : clients) {
      // New output is written at once if the socket accepts it; another round of poll would add latency.
      if (client->HasOutput() && !client->Write()) ended.push_back(client.get());
      client->CheckPatience(now);
    }
    std::erase_if(clients,
                  [&](const auto& c) { return std::find(ended.begin(), ended.end(), c.get()) != ended.end(); });
    if ((fds[1].revents & POLLIN) != 0) impl_->Accept();
    impl_->connected = static_cast<int64_t>(clients.size());
  }
}

}  // namespace plslam::bus
