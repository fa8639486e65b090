// SPDX-License-Identifier: BSD-3-Clause
#include "tests/support/lossy_lan.h"

#include <fcntl.h>
#include <linux/if.h>
#include <linux/if_tun.h>
#include <poll.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <stdexcept>

namespace plslam::test {
namespace {

constexpr int kBatch = 64;
constexpr size_t kLargestFrame = 2048;

/// In the network namespace of the calling thread.
int MakeTap() {
  const int fd = open("/dev/net/tun", O_RDWR | O_CLOEXEC | O_NONBLOCK);
  ifreq request{};
  std::strcpy(request.ifr_name, "eth0");
  request.ifr_flags = IFF_TAP | IFF_NO_PI;
  if (fd >= 0 && ioctl(fd, TUNSETIFF, &request) == 0) return fd;
  const std::string why = std::strerror(errno);
  if (fd >= 0) close(fd);
  throw std::runtime_error("no TAP interface can be made: " + why);
}

}  // namespace

std::string LossyLan::Obstacle() {
  if (!NetworkHost::Obstacle().empty()) return NetworkHost::Obstacle();
  try {
    const LossyLan probe(1, Faults());
  } catch (const std::exception& error) {
    return error.what();
  }
  return "";
}

LossyLan::LossyLan(int n_hosts, const Faults& faults) : faults_(faults), random_(faults.seed) {
  for (int i = 0; i < n_hosts; ++i) {
    Port& port = ports_.emplace_back();
    port.host = std::make_unique<NetworkHost>();
    port.host->Do([&] { port.fd = MakeTap(); });
    port.host->Shell("ip link set eth0 txqueuelen 10000 && ip addr add 10.77.0." + std::to_string(i + 1) +
                     "/24 dev eth0 && ip link set eth0 up && ip route add 224.0.0.0/4 dev eth0");
  }
  thread_ = std::thread([this] { Run(); });
}

LossyLan::~LossyLan() {
  stopping_ = true;
  thread_.join();
  for (const Port& port : ports_) close(port.fd);
}

void LossyLan::Send(size_t to, const Packet& packet) {
  const auto now = Clock::now();
  const auto due = Chance(faults_.overtaking) ? now : now + faults_.delay;
  flights_.push({due, number_++, to, packet});
}

void LossyLan::Take(size_t port) {
  std::array<uint8_t, kLargestFrame> frame;
  for (int i = 0; i < kBatch; ++i) {
    const ssize_t n = read(ports_[port].fd, frame.data(), frame.size());
    if (n <= 0) return;
    const auto packet = std::make_shared<const std::vector<uint8_t>>(frame.begin(), frame.begin() + n);
    for (size_t to = 0; to < ports_.size(); ++to) {
      if (to == port) continue;
      if (Chance(faults_.lost)) {
        ++lost_;
        continue;
      }
      Send(to, packet);
      if (Chance(faults_.doubled)) Send(to, packet);
    }
  }
}

void LossyLan::Land() {
  const auto now = Clock::now();
  while (!flights_.empty() && flights_.top().due <= now) {
    const Flight& flight = flights_.top();
    // A packet is lost if the queue of the host is full, as in any network.
    const bool taken = write(ports_[flight.to].fd, flight.packet->data(), flight.packet->size()) > 0;
    ++(taken ? delivered_ : lost_);
    flights_.pop();
  }
}

void LossyLan::Run() {
  static constexpr std::chrono::nanoseconds kLookAgain = std::chrono::milliseconds(20);
  std::vector<pollfd> fds;
  for (const Port& port : ports_) fds.push_back({port.fd, POLLIN, 0});
  while (!stopping_) {
    const std::chrono::nanoseconds until_next = flights_.empty() ? kLookAgain : flights_.top().due - Clock::now();
    const timespec wait = {0, std::clamp(until_next, std::chrono::nanoseconds(0), kLookAgain).count()};
    ppoll(fds.data(), fds.size(), &wait, nullptr);
    for (size_t i = 0; i < fds.size(); ++i) {
      if ((fds[i].revents & POLLIN) != 0) Take(i);
    }
    Land();
  }
}

}  // namespace plslam::test
