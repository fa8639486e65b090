// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <atomic>
#include <cstdint>
#include <random>
#include <string>
#include <thread>
#include <vector>

namespace plslam::test {

/// A hostile member of an LCM multicast group: it sends junk of several types, in turn, at a fixed rate. It listens to
/// the other members, and repeats and alters their packets, too. Seeded; received packets depend on the others.
class HostileSender {
 public:
  struct Plan {
    std::string group;
    uint16_t port = 0;
    int per_second = 10'000;
    /// Targeted names on the wire.
    std::vector<std::string> channels;
    /// Also send packets against which only a key protects: datagrams of others with bits flipped, and `recording`.
    bool forge = false;
    /// Packets of an earlier run, which were genuine then.
    std::vector<std::vector<uint8_t>> recording;
    uint64_t seed = 1;
  };

  /// Starts at once, in the network namespace of the calling thread. Throws std::runtime_error if it gets no socket.
  explicit HostileSender(Plan plan);
  ~HostileSender();
  HostileSender(const HostileSender&) = delete;
  HostileSender& operator=(const HostileSender&) = delete;

  int64_t sent() const { return sent_; }
  /// Datagrams in a second so far.
  double rate() const;

  /// An LCM packet of a message.
  static std::vector<uint8_t> Packet(const std::string& channel, const std::vector<uint8_t>& data);

 private:
  void Run();
  void Listen();
  std::vector<uint8_t> Next();
  std::vector<uint8_t> Random(size_t most);
  std::vector<uint8_t> Fragment();
  std::vector<uint8_t> Altered(std::vector<uint8_t> packet);
  const std::string& AnyChannel();

  const Plan plan_;
  int fd_ = -1;
  std::mt19937_64 random_;
  std::vector<std::vector<uint8_t>> heard_;
  size_t next_heard_ = 0;
  size_t next_recorded_ = 0;
  std::atomic<int64_t> sent_{0};
  std::atomic<double> seconds_{0.0};
  std::atomic<bool> stopping_{false};
  std::thread thread_;
};

}  // namespace plslam::test
