// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace plslam::test {

/// A host with addresses of its own, within this machine: a Linux network namespace. It goes when the last process in
/// it has ended, and nothing of it is seen from outside. Its loopback carries multicast, as on any host.
class NetworkHost {
 public:
  /// Why this kernel grants this user no such host; empty where it does. The first call may put this process into a
  /// user namespace (where it is not root), so it comes before any thread.
  static const std::string& Obstacle();

  /// Throws std::runtime_error where there is an obstacle.
  NetworkHost();
  ~NetworkHost();
  NetworkHost(const NetworkHost&) = delete;
  NetworkHost& operator=(const NetworkHost&) = delete;

  /// Calls `f` with the calling thread in this host: sockets, threads and processes made then belong there.
  void Do(const std::function<void()>& f) const;
  /// A shell command in this host; throws std::runtime_error with what it says where it fails.
  void Shell(const std::string& command) const;
  /// For `ip link ... netns PATH`.
  std::string path() const;

 private:
  int fd_ = -1;
};

/// Hosts joined by a switch: each has an interface eth0 (MTU 1500) with the address 10.77.0.1, .2, ... and a route
/// for multicast over it.
class Lan {
 public:
  explicit Lan(int n_hosts);

  const NetworkHost& host(int i) const { return *hosts_.at(static_cast<size_t>(i)); }
  /// Pulls the cable of a host out of the switch, or puts it back.
  void SetLink(int i, bool up) const;

 private:
  NetworkHost switch_;
  std::vector<std::unique_ptr<NetworkHost>> hosts_;
};

}  // namespace plslam::test
