// SPDX-License-Identifier: BSD-3-Clause
#include "tests/support/network_host.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sched.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <stdexcept>

namespace plslam::test {
namespace {

constexpr const char* kOwnNamespace = "/proc/thread-self/ns/net";

int OpenNamespace() { return open(kOwnNamespace, O_RDONLY | O_CLOEXEC); }

/// Without root privileges: root of a user namespace may create network namespaces.
bool EnterUserNamespace() {
  const uid_t user = geteuid();
  const gid_t group = getegid();
  if (unshare(CLONE_NEWUSER) != 0) return false;
  std::ofstream("/proc/self/setgroups") << "deny";
  std::ofstream("/proc/self/uid_map") << "0 " << user << " 1";
  std::ofstream("/proc/self/gid_map") << "0 " << group << " 1";
  return true;
}

/// Exit code and output.
std::pair<int, std::string> RunShell(const std::string& command) {
  std::string output;
  FILE* pipe = popen(("(" + command + ") 2>&1").c_str(), "re");
  if (pipe == nullptr) return {-1, std::strerror(errno)};
  std::array<char, 512> part{};
  while (fgets(part.data(), part.size(), pipe) != nullptr) output += part.data();
  return {pclose(pipe), output};
}

std::string FindObstacle() {
  if (geteuid() != 0 && !EnterUserNamespace()) {
    return std::string("no user namespace is granted: ") + std::strerror(errno);
  }
  try {
    const NetworkHost probe;
    probe.Shell("ip link add plslam0 type veth peer name plslam1");
  } catch (const std::exception& error) {
    return error.what();
  }
  return "";
}

}  // namespace

const std::string& NetworkHost::Obstacle() {
  static const std::string obstacle = FindObstacle();
  return obstacle;
}

NetworkHost::NetworkHost() {
  const int outside = OpenNamespace();
  if (outside < 0 || unshare(CLONE_NEWNET) != 0) {
    const std::string why = std::strerror(errno);
    if (outside >= 0) close(outside);
    throw std::runtime_error("no network namespace is granted: " + why);
  }
  fd_ = OpenNamespace();
  setns(outside, CLONE_NEWNET);
  close(outside);
  Shell("ip link set lo up && ip link set lo multicast on && ip route add 224.0.0.0/4 dev lo metric 100");
}

NetworkHost::~NetworkHost() { close(fd_); }

void NetworkHost::Do(const std::function<void()>& f) const {
  struct Outside {
    int fd = OpenNamespace();
    ~Outside() {
      setns(fd, CLONE_NEWNET);
      close(fd);
    }
  } const outside;
  if (setns(fd_, CLONE_NEWNET) != 0) throw std::runtime_error("the network namespace cannot be entered");
  f();
}

void NetworkHost::Shell(const std::string& command) const {
  std::pair<int, std::string> result;
  Do([&] { result = RunShell(command); });
  if (result.first != 0) throw std::runtime_error(fmt::format("'{}' failed: {}", command, result.second));
}

std::string NetworkHost::path() const { return fmt::format("/proc/{}/fd/{}", getpid(), fd_); }

Lan::Lan(int n_hosts) {
  switch_.Shell("ip link add br0 type bridge && ip link set br0 up");
  for (int i = 0; i < n_hosts; ++i) {
    const NetworkHost& host = *hosts_.emplace_back(std::make_unique<NetworkHost>());
    switch_.Shell(
        fmt::format("ip link add port{0} type veth peer name eth0 netns {1} && ip link set port{0} master br0 up", i,
                    host.path()));
    host.Shell(
        fmt::format("ip addr add 10.77.0.{}/24 dev eth0 && ip link set eth0 up && "
                    "ip route add 224.0.0.0/4 dev eth0",
                    i + 1));
  }
}

void Lan::SetLink(int i, bool up) const {
  switch_.Shell("ip link set port" + std::to_string(i) + (up ? " up" : " down"));
}

}  // namespace plslam::test
