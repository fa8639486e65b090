// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace plslam::test {

/// A host with its own addresses, within this machine: a Linux network namespace. It is removed when the last process
/// in it has exited, and is invisible from outside. Its loopback carries multicast, as on any host.
class NetworkHost {
 public:
  /// Returns the reason why this kernel does not grant this user such a host; empty if it does. The first call may move
  /// this process into a user namespace (unless it is root), so it precedes any thread.
  static const std::string& Obstacle();

  /// Throws std::runtime_error if there is an obstacle.
  NetworkHost();
  ~NetworkHost();
  NetworkHost(const NetworkHost&) = delete;
  NetworkHost& operator=(const NetworkHost&) = delete;

  /// Calls `f` with the calling thread in this host: sockets, threads and processes created by it belong there.
  void Do(const std::function<void()>& f) const;
  /// Runs a shell command in this host; throws std::runtime_error with its output if it fails.
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
