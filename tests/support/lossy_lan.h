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

/// Hosts connected by a bad network: our own switch forwards the packets of their kernels (TAP interfaces eth0, MTU
/// 1500, addresses 10.77.0.1, .2, ..., multicast routed over them), and drops, doubles, delays and reorders them on the
/// way to each receiver. Needs no netem of the kernel. Traffic within a host is not affected.
class LossyLan {
 public:
  /// Probabilities of faults of each packet on its way to each receiver.
  struct Faults {
    double lost = 0.0;
    double doubled = 0.0;
    /// The packet skips its delay, and so overtakes earlier ones.
    double overtaking = 0.0;
    std::chrono::microseconds delay{0};
    uint64_t seed = 1;
  };

  /// Returns the reason why it is not available here; empty if it is. First call: see NetworkHost::Obstacle.
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
