// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace plslam::bus {

/// Decides how large a publisher's messages may be. A datagram of 60,000 bytes is 41 packets on a network with an MTU of
/// 1,500, and is lost if one of them is: at 1 % of lost packets that is a third of the datagrams. If more than one in
/// twenty large messages needs repair, pages and strips become single packets for a while, which doubles each time, and
/// larger messages are sent, and sent again, in parts of one packet (`PacketParts`). Results do not depend on the size. Time in nanoseconds of any steady clock; not thread-safe.
class MessageSize {
 public:
  /// A message of this size fits one packet, its key's MAC and LCM's header included.
  static constexpr int64_t kPacket_bytes = 1200;

  void OnSent(int64_t bytes) {
    if (bytes <= kPacket_bytes) return;
    ++sent_;
    if (sent_ < kMemory) return;
    sent_ /= 2;
    lost_ /= 2;
  }
  /// `n` large messages were requested again for the first time. Returns whether they are small from now on, and were
  /// not before.
  bool OnLost(int64_t n, int64_t now) {
    lost_ += n;
    if (IsSmall(now) || lost_ < kLeastLost || !IsMany()) return false;
    percent_ = std::min<int64_t>(100, 100 * lost_ / std::max<int64_t>(sent_, 1));
    small_until_ = now + period_;
    period_ = std::min(2 * period_, kLongest);
    sent_ = lost_ = 0;
    return true;
  }
  bool IsSmall(int64_t now) const { return now < small_until_; }
  /// Share of large messages that needed repair when they became small.
  int64_t percent() const { return percent_; }

 private:
  static constexpr int64_t kOneIn = 20;
  /// A single burst, as of a reader that starts, is no reason.
  static constexpr int64_t kLeastLost = 3;
  static constexpr int64_t kMemory = 400;
  static constexpr int64_t kFirst = 30'000'000'000;
  static constexpr int64_t kLongest = 3'600'000'000'000;

  /// More than one in twenty, by three standard deviations: a datagram here and there costs less than many small ones.
  bool IsMany() const {
    const double usual = static_cast<double>(sent_) / kOneIn;
    return static_cast<double>(lost_) > usual + 3.0 * std::sqrt(usual);
  }

  int64_t sent_ = 0;
  int64_t lost_ = 0;
  int64_t percent_ = 0;
  int64_t small_until_ = 0;
  int64_t period_ = kFirst;
};

}  // namespace plslam::bus
