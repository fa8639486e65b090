// SPDX-License-Identifier: BSD-3-Clause
#include "tools/doctor/socket_check.h"

#include <netdb.h>
#include <netinet/in.h>
#include <poll.h>
#include <unistd.h>

#include <sys/socket.h>
#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <sstream>
#include <stdexcept>
#include <string_view>

#include <fmt/format.h>

#include "core/bus/transport/transport.h"

namespace plslam::doctor {
namespace {

int Number(const std::string& url, std::string_view text, int min, int max) {
  int value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size() || value < min || value > max) {
    throw std::runtime_error(fmt::format("bus.url: {}: '{}' is not a number from {} to {}", url, text, min, max));
  }
  return value;
}

/// Returns the value of `key` among the parameters after '?', separated by '&'; empty if it is absent.
std::string_view Parameter(std::string_view parameters, std::string_view key) {
  while (!parameters.empty()) {
    const std::string_view one = parameters.substr(0, parameters.find('&'));
    parameters.remove_prefix(std::min(parameters.size(), one.size() + 1));
    if (one.starts_with(key) && one.size() > key.size() && one[key.size()] == '=') return one.substr(key.size() + 1);
  }
  return {};
}

}  // namespace

BusAddress ParseBusAddress(const std::string& url) {
  BusAddress address;
  address.url = bus::EffectiveUrl(url);
  std::string_view rest = address.url;
  if (rest.starts_with("udpm://")) address.kind = BusAddress::Kind::kMulticast;
  if (rest.starts_with("tcpq://")) address.kind = BusAddress::Kind::kRelay;
  if (address.kind == BusAddress::Kind::kOther) return address;
  if (address.kind == BusAddress::Kind::kRelay) {
    address.host = "127.0.0.1";
    address.port = 7700;
  }
  rest.remove_prefix(std::string_view("udpm://").size());
  const size_t question = rest.find('?');
  const std::string_view network = rest.substr(0, question);
  const std::string_view parameters = question == std::string_view::npos ? "" : rest.substr(question + 1);
  const size_t colon = network.find(':');
  if (!network.substr(0, colon).empty()) address.host = network.substr(0, colon);
  if (colon != std::string_view::npos) address.port = Number(address.url, network.substr(colon + 1), 1, 65535);
  if (const auto ttl = Parameter(parameters, "ttl"); !ttl.empty()) address.ttl = Number(address.url, ttl, 0, 255);
  if (const auto size = Parameter(parameters, "recv_buf_size"); !size.empty()) {
    address.receive_buffer = Number(address.url, size, 1, 1 << 30);
  }
  return address;
}

namespace {

constexpr int kWantedBytes = bus::kWantedReceiveBuffer;

class Socket {
 public:
  Socket(int family, int type) : fd_(socket(family, type | SOCK_CLOEXEC, 0)) {}
  ~Socket() { close(fd_); }
  Socket(const Socket&) = delete;
  Socket& operator=(const Socket&) = delete;
  int fd() const { return fd_; }

 private:
  int fd_;
};

std::vector<UdpSocket> UdpSockets() {
  std::ifstream file("/proc/net/udp");
  return ParseUdpSockets({std::istreambuf_iterator<char>(file), {}});
}

int64_t BufferErrors() {
  std::ifstream file("/proc/net/snmp");
  return ParseBufferErrors({std::istreambuf_iterator<char>(file), {}});
}

/// Returns the size that the kernel grants: it doubles the number for its own overhead, and limits it to
/// net.core.rmem_max.
int GrantedBytes(int wanted) {
  const Socket socket(AF_INET, SOCK_DGRAM);
  int bytes = 0;
  socklen_t length = sizeof bytes;
  setsockopt(socket.fd(), SOL_SOCKET, SO_RCVBUF, &wanted, sizeof wanted);
  getsockopt(socket.fd(), SOL_SOCKET, SO_RCVBUF, &bytes, &length);
  return bytes / 2;
}

bool HoldsSocket(const std::filesystem::path& process, const std::string& wanted) {
  std::error_code error;
  for (auto fd = std::filesystem::directory_iterator(process / "fd", error);
       !error && fd != std::filesystem::directory_iterator(); fd.increment(error)) {
    std::error_code gone;
    if (std::filesystem::read_symlink(fd->path(), gone) == wanted) return true;
  }
  return false;
}

/// Returns "name (process 123)" of the process that holds the UDP port, as far as this user may see it.
std::string HolderOf(int port, int* pid) {
  const auto sockets = UdpSockets();
  const auto it = std::find_if(sockets.begin(), sockets.end(), [&](const UdpSocket& s) { return s.port == port; });
  if (it == sockets.end()) return "a program of another network namespace";
  const std::string wanted = fmt::format("socket:[{}]", it->inode);
  for (const auto& process : std::filesystem::directory_iterator("/proc")) {
    const std::string id = process.path().filename();
    if (id.find_first_not_of("0123456789") != std::string::npos || !HoldsSocket(process.path(), wanted)) continue;
    std::ifstream comm(process.path() / "comm");
    std::string name;
    std::getline(comm, name);
    *pid = std::stoi(id);
    return fmt::format("{} (process {})", name, id);
  }
  return "a program of another user";
}

Findings CheckUdpPort(const BusAddress& address) {
  const Socket socket(AF_INET, SOCK_DGRAM);
  const int on = 1;
  setsockopt(socket.fd(), SOL_SOCKET, SO_REUSEADDR, &on, sizeof on);
  sockaddr_in name{};
  name.sin_family = AF_INET;
  name.sin_port = htons(static_cast<uint16_t>(address.port));
  if (bind(socket.fd(), reinterpret_cast<const sockaddr*>(&name), sizeof name) == 0) {
    return {Good("port", fmt::format("UDP port {} can be shared with other LCM programs", address.port))};
  }
  if (errno != EADDRINUSE) {
    return {Problem("port", fmt::format("UDP port {} cannot be opened: {}", address.port, std::strerror(errno)),
                    fmt::format("export LCM_DEFAULT_URL=udpm://{}:{}?ttl={}", address.host, 7667, address.ttl))};
  }
  int pid = 0;
  const std::string holder = HolderOf(address.port, &pid);
  const std::string other_port =
      fmt::format("export LCM_DEFAULT_URL=udpm://{}:{}?ttl={}", address.host, address.port + 1, address.ttl);
  return {Problem("port",
                  fmt::format("UDP port {} is used by {}, which does not share it as LCM does", address.port, holder),
                  pid > 0 ? fmt::format("kill {}   # or, everywhere: {}", pid, other_port) : other_port)};
}

/// Exchanges the greeting of LCM's tcpq protocol; returns false if the other side is no LCM relay, or is silent for a
/// second.
bool AnswersHello(int fd) {
  static constexpr std::array<uint8_t, 8> kHello = {0x28, 0x76, 0x17, 0xfb, 0, 0, 0x01, 0};
  static constexpr std::array<uint8_t, 4> kAnswer = {0x28, 0x76, 0x17, 0xfa};
  if (send(fd, kHello.data(), kHello.size(), MSG_NOSIGNAL) != static_cast<ssize_t>(kHello.size())) return false;
  std::array<uint8_t, 8> answer{};
  pollfd readable = {fd, POLLIN, 0};
  if (poll(&readable, 1, 1000) <= 0) return false;
  if (recv(fd, answer.data(), answer.size(), MSG_WAITALL) != static_cast<ssize_t>(answer.size())) return false;
  return std::equal(kAnswer.begin(), kAnswer.end(), answer.begin());
}

/// Returns the reason why there is no connection to `host`; empty if an LCM relay answers.
std::string WhyNoRelay(const BusAddress& address) {
  addrinfo hints{};
  hints.ai_family = AF_INET;
  hints.ai_socktype = SOCK_STREAM;
  addrinfo* found = nullptr;
  const int error = getaddrinfo(address.host.c_str(), std::to_string(address.port).c_str(), &hints, &found);
  if (error != 0) return fmt::format("the host {} is unknown: {}", address.host, gai_strerror(error));
  const Socket socket(AF_INET, SOCK_STREAM);
  const timeval limit{2, 0};
  setsockopt(socket.fd(), SOL_SOCKET, SO_SNDTIMEO, &limit, sizeof limit);
  setsockopt(socket.fd(), SOL_SOCKET, SO_RCVTIMEO, &limit, sizeof limit);
  const bool connected = connect(socket.fd(), found->ai_addr, found->ai_addrlen) == 0;
  const int why = errno;
  freeaddrinfo(found);
  if (!connected) {
    return fmt::format("nothing answers at {}:{}: {}", address.host, address.port,
                       std::strerror(why == EINPROGRESS ? ETIMEDOUT : why));
  }
  if (!AnswersHello(socket.fd()))
    return fmt::format("the program that answers at {}:{} is not an LCM relay", address.host, address.port);
  return "";
}

}  // namespace

std::vector<UdpSocket> ParseUdpSockets(const std::string& table) {
  std::vector<UdpSocket> sockets;
  std::istringstream lines(table);
  std::string line;
  std::getline(lines, line);  // names of the columns
  while (std::getline(lines, line)) {
    std::istringstream stream(line);
    const std::vector<std::string> columns{std::istream_iterator<std::string>(stream), {}};
    if (columns.size() < 13 || columns[1].size() != 13) continue;
    sockets.push_back({static_cast<int>(std::strtol(columns[1].c_str() + 9, nullptr, 16)),
                       std::strtoll(columns[9].c_str(), nullptr, 10),
                       std::strtoll(columns[12].c_str(), nullptr, 10)});
  }
  return sockets;
}

int64_t ParseBufferErrors(const std::string& table) {
  std::istringstream lines(table);
  std::vector<std::string> names;
  for (std::string line; std::getline(lines, line);) {
    if (!line.starts_with("Udp: ")) continue;
    std::istringstream stream(line);
    const std::vector<std::string> columns{std::istream_iterator<std::string>(stream), {}};
    const auto name = std::ranges::find(names, "RcvbufErrors");
    const size_t index = static_cast<size_t>(name - names.begin());
    if (name != names.end() && index < columns.size()) return std::strtoll(columns[index].c_str(), nullptr, 10);
    names = columns;
  }
  return 0;
}

Findings CheckReceiveBuffer(const BusAddress& address) {
  const int wanted = address.receive_buffer > 0 ? address.receive_buffer : kWantedBytes;
  const int granted = GrantedBytes(wanted);
  const std::string grow = AsRoot(fmt::format("sysctl -w net.core.rmem_max={}", std::max(wanted, kWantedBytes)));
  Findings findings;
  if (granted >= wanted) {
    findings.push_back(Good("buffer", fmt::format("the kernel grants receive buffers of {} bytes", granted)));
  } else {
    findings.push_back(Advice("buffer",
                              fmt::format("the kernel grants receive buffers of {} of {} bytes: bursts will be sent "
                                          "again, which costs time",
                                          granted, wanted),
                              grow));
  }
  int64_t drops = 0;
  for (const UdpSocket& socket : UdpSockets()) {
    if (socket.port == address.port) drops += socket.drops;
  }
  // The drops of a socket include what its filter rejects, as the bus's own filter does.
  drops = std::min(drops, BufferErrors());
  if (drops > 0) {
    findings.push_back(Advice("buffer",
                              fmt::format("sockets on UDP port {} of this host have lost {} datagrams because their "
                                          "buffers were full",
                                          address.port, drops),
                              granted < wanted ? grow : "nproc; uptime   # more work than processors?"));
  }
  return findings;
}

Findings CheckPort(const BusAddress& address) {
  if (address.kind == BusAddress::Kind::kMulticast) return CheckUdpPort(address);
  const std::string why = WhyNoRelay(address);
  if (why.empty()) return {Good("port", fmt::format("an LCM relay answers at {}:{}", address.host, address.port))};
  return {Problem("port", why,
                  fmt::format("plslam relay --port {} --address 0.0.0.0 &   # on {}", address.port, address.host))};
}

}  // namespace plslam::doctor
