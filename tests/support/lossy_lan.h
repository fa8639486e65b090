// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <queue>
#include <random>
#include <string>
#include <thread>
#include <vector>

#include "tests/support/network_host.h"

namespace plslam::test {

/// Hosts joined by a bad network: a switch of our own hands on what their kernels send (TAP interfaces eth0, MTU
/// 1500, addresses 10.77.0.1, .2, ..., multicast routed over them), packet by packet, and loses, doubles, delays and
/// reorders on the way to each receiver. Needs no netem of the kernel. Traffic within a host is not touched.
class LossyLan {
 public:
  /// Of each packet on its way to each receiver, by chance.
  struct Faults {
    double lost = 0.0;
    double doubled = 0.0;
    /// Does not wait for its delay, and so overtakes those before it.
    double overtaking = 0.0;
    std::chrono::microseconds delay{0};
    uint64_t seed = 1;
  };

  /// Why it cannot be had here; empty where it can. First call: see NetworkHost::Obstacle.
  static std::string Obstacle();

  LossyLan(int n_hosts, const Faults& faults);
  ~LossyLan();
  LossyLan(const LossyLan&) = delete;
  LossyLan& operator=(const LossyLan&) = delete;

  const NetworkHost& host(int i) const { return *ports_.at(static_cast<size_t>(i)).host; }
  /// Packets handed on, one for each receiver, and those not.
  int64_t delivered() const { return delivered_; }
  int64_t lost() const { return lost_; }

 private:
  using Clock = std::chrono::steady_clock;
  using Packet = std::shared_ptr<const std::vector<uint8_t>>;
  struct Port {
    std::unique_ptr<NetworkHost> host;
    int fd = -1;
  };
  struct Flight {
    Clock::time_point due;
    int64_t number = 0;  // of those due at the same time the older goes first
    size_t to = 0;
    Packet packet;
    bool operator>(const Flight& other) const { return due != other.due ? due > other.due : number > other.number; }
  };

  void Run();
  void Take(size_t port);
  void Send(size_t to, const Packet& packet);
  void Land();
  bool Chance(double share) { return static_cast<double>(random_() >> 11) * 0x1p-53 < share; }

  const Faults faults_;
  std::vector<Port> ports_;
  std::mt19937_64 random_;
  std::priority_queue<Flight, std::vector<Flight>, std::greater<>> flights_;
  int64_t number_ = 0;
  std::atomic<int64_t> delivered_{0};
  std::atomic<int64_t> lost_{0};
  std::atomic<bool> stopping_{false};
  std::thread thread_;
};

}  // namespace plslam::test
