// SPDX-License-Identifier: BSD-3-Clause
#include "mapping_process/node/keyframe_queue.h"

#include <algorithm>
#include <limits>
#include <random>
#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace plslam::mapping {
namespace {

constexpr double kLater_ms = KeyframeQueue::kPatience_ms + 1.0;

Keyframe KeyframeOf(SessionId session, int64_t id, SourceId source, int64_t t_ns = 0) {
  Keyframe keyframe;
  keyframe.name.session = session;
  keyframe.name.number = id;
  keyframe.source = source;
  keyframe.t_ns = t_ns;
  return keyframe;
}

/// Returns the keyframes that can be taken, such as "7.0 7.1 8.0".
std::string TakeAll(KeyframeQueue& queue, double now_ms) {
  std::string taken;
  while (const auto next = queue.Take(now_ms)) {
    if (next->missing > 0) taken += "(" + std::to_string(next->missing) + ") ";
    taken +=
        std::to_string(next->keyframe.name.session.value) + "." + std::to_string(next->keyframe.name.number) + " ";
  }
  return taken;
}

TEST(KeyframeQueue, SessionFromTwoPublishersIsInOrder) {
  KeyframeQueue queue;
  // The live tracker, then the history keeper with messages of the exited one.
  for (const int64_t id : {4, 5, 6}) EXPECT_TRUE(queue.Add(KeyframeOf(7, id, 1), 0.0));
  EXPECT_EQ(TakeAll(queue, 1.0), "");
  for (const int64_t id : {0, 1, 2, 3, 4, 5}) EXPECT_EQ(queue.Add(KeyframeOf(7, id, 2), 2.0), id < 4);
  EXPECT_EQ(queue.size(), 7U);
  EXPECT_EQ(TakeAll(queue, 3.0), "7.0 7.1 7.2 7.3 7.4 7.5 7.6 ");
  EXPECT_FALSE(queue.Add(KeyframeOf(7, 6, 2), 4.0));
  EXPECT_EQ(queue.size(), 0U);
}

TEST(KeyframeQueue, DroppedSessionDoesNotDelayOthers) {
  KeyframeQueue queue;
  for (const SessionId session : {7, 8}) queue.Add(KeyframeOf(session, 0, 1), 0.0);
  queue.Drop(7);
  queue.Drop(9);
  EXPECT_EQ(TakeAll(queue, 1.0), "8.0 ");
}

TEST(KeyframeQueue, RandomOrderFromSeveralPublishers) {
  std::mt19937 random(1);
  for (int trial = 0; trial < 200; ++trial) {
    // Two sessions, each divided at a keyframe that both publishers have; both parts of each are published twice.
    std::vector<std::vector<Keyframe>> published;
    for (const SessionId session : {7, 8}) {
      const int64_t cut = random() % 10;
      for (int source = 1; source <= 4; ++source) {
        std::vector<Keyframe>& of = published.emplace_back();
        const int64_t begin = source % 2 == 0 ? 0 : cut;
        const int64_t end = source % 2 == 0 ? cut + 1 : 10;
        for (int64_t id = begin; id < end; ++id)
          of.push_back(KeyframeOf(session, id, SourceId(10 * session.value + source)));
      }
    }
    KeyframeQueue queue;
    std::vector<int64_t> next = {0, 0};
    const auto take = [&] {
      while (const auto taken = queue.Take(0.0)) {
        ASSERT_EQ(taken->keyframe.name.number, next[static_cast<size_t>(taken->keyframe.name.session.value - 7)]++);
      }
    };
    while (!published.empty()) {
      std::vector<Keyframe>& of = published[random() % published.size()];
      queue.Add(of.front(), 0.0);
      of.erase(of.begin());
      std::erase_if(published, [](const auto& rest) { return rest.empty(); });
      if (random() % 3 == 0) take();
      if (testing::Test::HasFatalFailure()) return;
    }
    ASSERT_NO_FATAL_FAILURE(take());
    EXPECT_EQ(next, (std::vector<int64_t>{10, 10}));
  }
}

TEST(KeyframeQueue, WaitsForMissingKeyframesUntilATimeout) {
  KeyframeQueue queue;
  for (const int64_t id : {0, 3, 4}) queue.Add(KeyframeOf(7, id, 1), 0.0);
  EXPECT_EQ(TakeAll(queue, 1000.0), "7.0 ");
  EXPECT_EQ(TakeAll(queue, kLater_ms), "") << "since the one before was taken";
  queue.Add(KeyframeOf(7, 2, 2), kLater_ms);
  EXPECT_EQ(TakeAll(queue, 1000.0 + kLater_ms), "") << "more is coming";
  EXPECT_EQ(TakeAll(queue, 2.0 * kLater_ms), "(1) 7.2 7.3 7.4 ");
  EXPECT_FALSE(queue.Add(KeyframeOf(7, 1, 2), 2.0 * kLater_ms)) << "too late";
}

TEST(KeyframeQueue, SessionWithoutItsBeginning) {
  KeyframeQueue queue;
  for (const int64_t id : {40, 41}) queue.Add(KeyframeOf(7, id, 1), 0.0);
  EXPECT_EQ(TakeAll(queue, 10.0), "");
  EXPECT_EQ(TakeAll(queue, kLater_ms), "(40) 7.40 7.41 ");
}

TEST(KeyframeQueue, OtherSessionsDoNotWait) {
  KeyframeQueue queue;
  queue.Add(KeyframeOf(7, 1, 1, 10), 0.0);
  queue.Add(KeyframeOf(8, 0, 2, 20), 0.0);
  EXPECT_EQ(TakeAll(queue, 1.0), "8.0 ");
  queue.Add(KeyframeOf(7, 0, 1, 5), 2.0);
  EXPECT_EQ(TakeAll(queue, 3.0), "7.0 7.1 ");
}

TEST(KeyframeQueue, NextSessionWaitsForThePreviousOne) {
  KeyframeQueue queue;
  queue.Add(KeyframeOf(7, 1, 1, 10), 0.0);
  queue.Add(KeyframeOf(8, 0, 1, 5), 0.0);
  EXPECT_EQ(TakeAll(queue, 1.0), "");
  queue.Add(KeyframeOf(7, 0, 2, 2), 2.0);
  EXPECT_EQ(TakeAll(queue, 3.0), "7.0 7.1 8.0 ");
}

TEST(KeyframeQueue, ContradictoryOrderDoesNotBlock) {
  KeyframeQueue queue;
  queue.Add(KeyframeOf(7, 0, 1, 10), 0.0);
  queue.Add(KeyframeOf(8, 0, 1, 20), 0.0);
  queue.Add(KeyframeOf(8, 1, 2, 30), 0.0);
  queue.Add(KeyframeOf(7, 1, 2, 40), 0.0);
  EXPECT_EQ(TakeAll(queue, 1.0), "7.0 8.0 8.1 7.1 ");
}

TEST(KeyframeQueue, InvalidKeyframeIdsAreRejected) {
  KeyframeQueue queue;
  EXPECT_FALSE(queue.Add(KeyframeOf(7, std::numeric_limits<int64_t>::max(), 1), 0.0));
  EXPECT_FALSE(queue.Add(KeyframeOf(7, KeyframeQueue::kLast + 1, 1), 0.0));
  EXPECT_TRUE(queue.Add(KeyframeOf(7, 0, 1), 0.0));
  EXPECT_EQ(TakeAll(queue, kLater_ms), "7.0 ");
}

TEST(KeyframeQueue, ContinuesAfterTheRestoredKeyframes) {
  KeyframeQueue queue;
  queue.Restore({{7, 4}});
  for (int64_t id = 0; id < 5; ++id) EXPECT_FALSE(queue.Add(KeyframeOf(7, id, 1), 0.0));
  queue.Add(KeyframeOf(7, 6, 1), 0.0);
  EXPECT_EQ(TakeAll(queue, 1.0), "");
  queue.Add(KeyframeOf(7, 5, 2), 1.0);
  EXPECT_EQ(TakeAll(queue, 2.0), "7.5 7.6 ");
}

}  // namespace
}  // namespace plslam::mapping
