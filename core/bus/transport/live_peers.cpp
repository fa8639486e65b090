// SPDX-License-Identifier: BSD-3-Clause
#include "core/bus/transport/live_peers.h"

#include <algorithm>
#include <tuple>

namespace plslam::bus {
namespace {

constexpr int64_t kFirstAskPause = 20'000'000;
constexpr int64_t kMaxAskPause = 1'000'000'000;
constexpr int64_t kAmpleTime = 3'000'000'000;
constexpr int64_t kSecond = 1'000'000'000;
constexpr int kMaxAskedInASecond = 100;

}  // namespace

bool ReplayWindow::Take(int64_t seq) {
  static constexpr int64_t kWidth = 64;
  if (seq > newest_) {
    const int64_t shift = seq - newest_;
    taken_ = (shift >= kWidth ? 0 : taken_ << shift) | 1;
    newest_ = seq;
    return true;
  }
  const int64_t age = newest_ - seq;
  if (age >= kWidth || (taken_ >> age & 1) != 0) return false;
  taken_ |= uint64_t{1} << age;
  return true;
}

LivePeers::Peer& LivePeers::PeerOf(SourceId source, int64_t now) {
  auto found = peers_.find(source);
  if (found == peers_.end()) {
    if (peers_.size() >= kMaxPeers) {
      // Recordings of many exited processes must not displace running ones.
      peers_.erase(std::min_element(peers_.begin(), peers_.end(), [](const auto& a, const auto& b) {
        return std::tie(a.second.lives, a.second.heard) < std::tie(b.second.lives, b.second.heard);
      }));
    }
    found = peers_.emplace(source, Peer{}).first;
    found->second.first = now;
    found->second.ask_pause = kFirstAskPause;
  }
  found->second.heard = now;
  return found->second;
}

void LivePeers::Prove(SourceId source, int64_t now) { PeerOf(source, now).lives = true; }

bool LivePeers::IsAlive(SourceId source) const {
  const auto found = peers_.find(source);
  return found != peers_.end() && found->second.lives;
}

LivePeers::Doubt LivePeers::OnSignOfLife(SourceId source, int64_t now) {
  Peer& peer = PeerOf(source, now);
  Doubt doubt;
  doubt.is_overdue = now - peer.first > kAmpleTime;
  if (now - second_began_ >= kSecond) {
    second_began_ = now;
    asked_ = 0;
  }
  doubt.ask = now >= peer.ask_at && asked_ < kMaxAskedInASecond;
  if (doubt.ask) {
    ++asked_;
    peer.ask_at = now + peer.ask_pause;
    peer.ask_pause = std::min(2 * peer.ask_pause, kMaxAskPause);
  }
  return doubt;
}

}  // namespace plslam::bus
