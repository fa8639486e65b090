// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>
#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include <regex.h>

namespace plslam::bus {

/// LCM's pattern of a subscription: matches whole channel names. See TcpqRelay for the supported syntax.
class ChannelPattern {
 public:
  explicit ChannelPattern(const std::string& pattern);
  ~ChannelPattern();
  ChannelPattern(const ChannelPattern&) = delete;
  ChannelPattern& operator=(const ChannelPattern&) = delete;

  const std::string& text() const { return text_; }
  bool Matches(const std::string& channel) const;

 private:
  std::string text_;
  bool valid_ = false;
  regex_t regex_{};
};

/// One connection of the relay: bytes in, bytes out, subscriptions. Sockets do not block.
class TcpqClient {
 public:
  using Clock = std::chrono::steady_clock;
  using Packet = std::shared_ptr<const std::vector<uint8_t>>;
  enum class Type : uint32_t { kPublish = 1, kSubscribe = 2, kUnsubscribe = 3 };

  /// A published message, in the form in which it is forwarded to readers.
  struct Publication {
    std::string channel;
    Packet packet;
  };

  explicit TcpqClient(int fd);
  ~TcpqClient();
  TcpqClient(const TcpqClient&) = delete;
  TcpqClient& operator=(const TcpqClient&) = delete;

  int fd() const { return fd_; }

  /// Reads the available bytes, and appends the published messages. Returns false if the connection has ended, or is
  /// `malformed()`.
  bool Read(std::vector<Publication>& published);
  bool malformed() const { return malformed_; }

  bool Wants(const std::string& channel);

  /// Queues a packet; returns the number of older ones dropped for it, where the client is stalled and full.
  int64_t Queue(const Packet& packet);
  bool HasOutput() const { return !output_.empty(); }
  /// Writes as much as the socket accepts. Returns false if the connection has ended.
  bool Write();

  /// Full, but not yet stalled.
  bool Congests() const { return !stalled_ && queued_bytes_ > high_; }
  /// Checks the time: a client whose queue has been full for long, and has not been half empty since, is stalled.
  /// Reading a little now and then does not prevent that.
  void CheckPatience(Clock::time_point now);

 private:
  bool Parse(std::vector<Publication>& published);
  bool ParseOne(size_t& at, std::vector<Publication>& published, bool& complete);
  bool Subscription(Type type, const std::string& pattern);
  uint32_t Word(size_t at) const;

  int fd_;
  int64_t high_;
  bool greeted_ = false;
  bool malformed_ = false;
  std::vector<uint8_t> input_;
  std::vector<std::unique_ptr<ChannelPattern>> patterns_;
  std::map<std::string, bool, std::less<>> wanted_;  // cached results of Wants
  std::deque<Packet> output_;
  size_t written_ = 0;  // of the first
  int64_t queued_bytes_ = 0;
  /// Since when the queue is full, or has not been half empty since.
  Clock::time_point full_since_ = Clock::time_point::max();
  bool stalled_ = false;
};

}  // namespace plslam::bus
