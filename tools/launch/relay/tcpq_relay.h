// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <string>

namespace plslam::bus {

/// The hub that LCM's `tcpq://HOST:PORT` URLs connect to: receives the messages of its clients and forwards them to
/// every client whose subscription matches, the publisher included. For machines without multicast, and for stock LCM
/// tools.
///
/// Lossless while all readers keep up: when one is slow, publishers wait for it. A reader that takes nothing for
/// kPatience_ms is not waited for any more; it loses its oldest messages (which the bus repairs on ordered channels)
/// until it has caught up. No client can stall the others for longer.
///
/// Subscriptions are POSIX extended regular expressions that must match the complete channel name; LCM itself uses Perl
/// ones, and patterns with look-ahead, back references or repetition counts match no channel here.
class TcpqRelay {
 public:
  static constexpr int kPatience_ms = 1000;
  static constexpr int64_t kQueueBytes = 32'000'000;
  static constexpr uint32_t kMaxMessageBytes = 16'000'000;
  static constexpr size_t kMaxClients = 64;

  struct Counters {
    int64_t clients = 0;    ///< connected now
    int64_t relayed = 0;    ///< messages taken from publishers
    int64_t dropped = 0;    ///< messages that a slow reader did not get
    int64_t malformed = 0;  ///< clients cut off for speaking nonsense
  };

  /// Listens at once, so that clients can connect before `Run`. Port 0: any free one. Throws std::runtime_error with
  /// one sentence where the address cannot be had.
  explicit TcpqRelay(int port = 7700, const std::string& address = "127.0.0.1");
  ~TcpqRelay();
  TcpqRelay(const TcpqRelay&) = delete;
  TcpqRelay& operator=(const TcpqRelay&) = delete;

  int port() const { return port_; }
  /// `tcpq://ADDRESS:PORT`.
  std::string url() const;

  /// Relays until `Stop` (from any thread, or a signal handler).
  void Run();
  void Stop();

  Counters counters() const;

 private:
  struct Impl;
  std::string address_;
  int port_ = 0;
  int wake_fd_ = -1;
  std::unique_ptr<Impl> impl_;
};

}  // namespace plslam::bus
