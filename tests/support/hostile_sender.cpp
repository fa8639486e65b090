// SPDX-License-Identifier: BSD-3-Clause
#include "tests/support/hostile_sender.h"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <chrono>
#include <cstring>
#include <stdexcept>
#include <utility>

namespace plslam::test {
namespace {

using Bytes = std::vector<uint8_t>;
using Clock = std::chrono::steady_clock;

// LCM's packets, words big-endian. Short: magic, number, channel, 0, data. Part of a long one: magic, number, size of
// the message, offset, part and parts (16 bits each); part 0 has the channel and a 0 before its data.
constexpr uint32_t kShort = 0x4c433032;
constexpr uint32_t kLong = 0x4c433033;
constexpr size_t kHeard = 256;
constexpr size_t kLargestDatagram = 65'507;

void Append(Bytes* bytes, uint32_t word, int n_bytes = 4) {
  for (int shift = 8 * (n_bytes - 1); shift >= 0; shift -= 8) bytes->push_back(static_cast<uint8_t>(word >> shift));
}

void Append(Bytes* bytes, const std::string& text) {
  bytes->insert(bytes->end(), text.begin(), text.end());
  bytes->push_back(0);
}

void Append(Bytes* bytes, const Bytes& more) { bytes->insert(bytes->end(), more.begin(), more.end()); }

int MakeSocket(const std::string& group, uint16_t port) {
  const int fd = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  const int yes = 1;
  const unsigned char ttl = 1;
  sockaddr_in name{};
  name.sin_family = AF_INET;
  name.sin_port = htons(port);
  ip_mreq membership{};
  const bool ok = fd >= 0 && inet_pton(AF_INET, group.c_str(), &membership.imr_multiaddr) == 1 &&
                  setsockopt(fd, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes) == 0 &&
                  bind(fd, reinterpret_cast<const sockaddr*>(&name), sizeof name) == 0 &&
                  setsockopt(fd, IPPROTO_IP, IP_ADD_MEMBERSHIP, &membership, sizeof membership) == 0 &&
                  setsockopt(fd, IPPROTO_IP, IP_MULTICAST_TTL, &ttl, sizeof ttl) == 0;
  if (!ok) {
    if (fd >= 0) close(fd);
    throw std::runtime_error("the group " + group + " cannot be joined: " + std::strerror(errno));
  }
  return fd;
}

}  // namespace

HostileSender::HostileSender(Plan plan) : plan_(std::move(plan)), random_(plan_.seed) {
  fd_ = MakeSocket(plan_.group, plan_.port);
  thread_ = std::thread([this] { Run(); });
}

HostileSender::~HostileSender() {
  stopping_ = true;
  thread_.join();
  close(fd_);
}

double HostileSender::rate() const { return seconds_ > 0.0 ? static_cast<double>(sent_) / seconds_ : 0.0; }

Bytes HostileSender::Packet(const std::string& channel, const Bytes& data) {
  Bytes packet;
  Append(&packet, kShort);
  Append(&packet, 0);
  Append(&packet, channel);
  Append(&packet, data);
  return packet;
}

const std::string& HostileSender::AnyChannel() { return plan_.channels[random_() % plan_.channels.size()]; }

Bytes HostileSender::Random(size_t most) {
  Bytes bytes(random_() % (most + 1));
  for (uint8_t& byte : bytes) byte = static_cast<uint8_t>(random_());
  return bytes;
}

/// Parts of messages that never become whole, claim to be huge, overlap, or lie beyond the end.
Bytes HostileSender::Fragment() {
  Bytes packet;
  Append(&packet, kLong);
  Append(&packet, static_cast<uint32_t>(random_() % 64));
  Append(&packet, random_() % 4 == 0 ? static_cast<uint32_t>(random_()) : static_cast<uint32_t>(random_() % 200'000));
  Append(&packet, random_() % 4 == 0 ? static_cast<uint32_t>(random_()) : static_cast<uint32_t>(random_() % 200'000));
  Append(&packet, static_cast<uint32_t>(random_() % 4), 2);
  Append(&packet, random_() % 4 == 0 ? static_cast<uint32_t>(random_()) : static_cast<uint32_t>(random_() % 5), 2);
  if (random_() % 2 == 0) Append(&packet, AnyChannel());
  Append(&packet, Random(1000));
  return packet;
}

Bytes HostileSender::Altered(Bytes packet) {
  // Our message begins after LCM's head and the channel name (which ends with the first zero after it).
  size_t begin = 8;
  while (begin < packet.size() && packet[begin] != 0) ++begin;
  if (++begin >= packet.size()) return packet;
  for (uint64_t n = 1 + random_() % 3; n > 0; --n) {
    const size_t at = begin + random_() % (packet.size() - begin);
    packet[at] ^= static_cast<uint8_t>(1U << random_() % 8);
  }
  return packet;
}

Bytes HostileSender::Next() {
  const uint64_t kind = random_() % 100;
  const bool has_heard = !heard_.empty();
  if (kind < 20) return Random(1400);
  if (kind < 40) return Packet(AnyChannel(), Random(600));
  if (kind < 55) return Fragment();
  if (kind < 70 && has_heard) return heard_[random_() % heard_.size()];
  if (kind < 71) return Packet(AnyChannel(), Bytes(kLargestDatagram - 100));
  if (!plan_.forge) return Packet(AnyChannel(), Random(100));
  if (kind < 85 && has_heard) return Altered(heard_[random_() % heard_.size()]);
  if (plan_.recording.empty()) return Random(100);
  return plan_.recording[next_recorded_++ % plan_.recording.size()];
}

/// Receives available packets, and keeps the smaller ones: large ones would make it a test of bandwidth.
void HostileSender::Listen() {
  static constexpr size_t kSmall = 4000;
  Bytes buffer(kLargestDatagram);
  for (int i = 0; i < 64; ++i) {
    sockaddr_in from{};
    socklen_t length = sizeof from;
    const ssize_t n =
        recvfrom(fd_, buffer.data(), buffer.size(), MSG_DONTWAIT, reinterpret_cast<sockaddr*>(&from), &length);
    if (n < 0) return;
    // We send from the port at which we listen, and LCM from a different one: our own junk is not repeated.
    const bool ours = ntohs(from.sin_port) == plan_.port;
    if (ours || static_cast<size_t>(n) > kSmall || n < 12) continue;
    Bytes packet(buffer.begin(), buffer.begin() + n);
    if (heard_.size() < kHeard) {
      heard_.push_back(std::move(packet));
    } else {
      heard_[next_heard_++ % kHeard] = std::move(packet);
    }
  }
}

void HostileSender::Run() {
  sockaddr_in to{};
  to.sin_family = AF_INET;
  to.sin_port = htons(plan_.port);
  inet_pton(AF_INET, plan_.group.c_str(), &to.sin_addr);
  const auto began = Clock::now();
  while (!stopping_) {
    const double seconds = std::chrono::duration<double>(Clock::now() - began).count();
    seconds_ = seconds;
    const auto due = static_cast<int64_t>(seconds * plan_.per_second);
    if (sent_ >= due) {
      Listen();
      std::this_thread::sleep_for(std::chrono::milliseconds(1));  // the pace of sending
      continue;
    }
    const Bytes packet = Next();
    sendto(fd_, packet.data(), packet.size(), MSG_DONTWAIT, reinterpret_cast<const sockaddr*>(&to), sizeof to);
    ++sent_;
  }
}

}  // namespace plslam::test
