// SPDX-License-Identifier: BSD-3-Clause
#include "core/bus/transport/live_peers.h"

#include <gtest/gtest.h>

#include <random>
#include <set>

namespace plslam::bus {
namespace {

constexpr int64_t kMs = 1'000'000;

TEST(ReplayWindow, TakesEachNumberOnce) {
  ReplayWindow window;
  for (const int64_t seq : {5, 3, 4, 60, 7, 0}) EXPECT_TRUE(window.Take(seq)) << seq;
  for (const int64_t seq : {5, 3, 4, 60, 7, 0}) EXPECT_FALSE(window.Take(seq)) << seq;
  EXPECT_TRUE(window.Take(INT64_MAX));
  EXPECT_FALSE(window.Take(61)) << "too old to tell";
}

TEST(ReplayWindow, AgreesWithASetOverRandomOrders) {
  std::mt19937_64 random(3);
  ReplayWindow window;
  std::set<int64_t> taken;
  int64_t newest = -1;
  for (int i = 0; i < 20'000; ++i) {
    const int64_t seq = std::max<int64_t>(0, i / 4 + static_cast<int64_t>(random() % 100) - 50);
    const bool is_new = !taken.contains(seq) && (seq > newest || newest - seq < 64);
    ASSERT_EQ(window.Take(seq), is_new) << seq << " after " << newest;
    if (is_new) taken.insert(seq);
    newest = std::max(newest, seq);
  }
}

TEST(LivePeers, RequestsBecomeLessFrequent) {
  LivePeers peers;
  std::vector<int64_t> times;
  for (int64_t now = 0; now < 3000 * kMs; now += kMs) {
    if (peers.OnSignOfLife(7, now).ask) times.push_back(now / kMs);
  }
  EXPECT_EQ(times, (std::vector<int64_t>{0, 20, 60, 140, 300, 620, 1260, 2260}));
}

TEST(LivePeers, ProofIsPermanent) {
  LivePeers peers;
  EXPECT_FALSE(peers.IsAlive(7));
  peers.OnSignOfLife(7, 0);
  EXPECT_FALSE(peers.IsAlive(7));
  peers.Prove(7, kMs);
  EXPECT_TRUE(peers.IsAlive(7));
  EXPECT_FALSE(peers.IsAlive(8));
}

TEST(LivePeers, UnprovenSourceTimesOutAfterThreeSeconds) {
  LivePeers peers;
  EXPECT_FALSE(peers.OnSignOfLife(7, 0).is_overdue);
  EXPECT_FALSE(peers.OnSignOfLife(7, 2999 * kMs).is_overdue);
  EXPECT_TRUE(peers.OnSignOfLife(7, 3001 * kMs).is_overdue);
}

TEST(LivePeers, ManyUnknownSourcesDoNotEvictProvenPeers) {
  LivePeers peers;
  peers.Prove(7, 0);
  int asked = 0;
  for (int source = 100; source < 100'000; ++source) asked += peers.OnSignOfLife(SourceId(source), kMs).ask ? 1 : 0;
  EXPECT_TRUE(peers.IsAlive(7));
  EXPECT_EQ(asked, 100);
}

}  // namespace
}  // namespace plslam::bus
