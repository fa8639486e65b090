// SPDX-License-Identifier: BSD-3-Clause
#include "core/robot/imu_queue.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace plslam::robot {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

std::vector<int64_t> Times(const std::vector<ImuSample>& samples) {
  std::vector<int64_t> times_ns;
  for (const ImuSample& sample : samples) times_ns.push_back(sample.t_ns);
  return times_ns;
}

TEST(ImuQueue, MotionsShareTheSampleBetweenThem) {
  ImuQueue queue;
  EXPECT_FALSE(queue.Covers(0));
  for (int64_t t = 0; t <= 40; t += 5) queue.Add({.t_ns = t});
  EXPECT_TRUE(queue.Covers(40));
  EXPECT_FALSE(queue.Covers(41));
  EXPECT_THAT(Times(queue.Take(12, 20)), ElementsAre(10, 15, 20));
  EXPECT_THAT(Times(queue.Take(20, 32)), ElementsAre(20, 25, 30, 35));
  EXPECT_THAT(Times(queue.Take(32, 38)), ElementsAre(30, 35, 40));
  EXPECT_EQ(queue.counts().n_late, 0);
}

TEST(ImuQueue, AnyOrderOfArrival) {
  ImuQueue queue;
  for (const int64_t t : {10, 0, 5, 15, 5}) queue.Add({.t_ns = t});
  EXPECT_THAT(Times(queue.Take(0, 15)), ElementsAre(0, 5, 10, 15));
  EXPECT_EQ(queue.counts().n, 5);
  EXPECT_EQ(queue.counts().n_repeated, 1);
}

TEST(ImuQueue, LateSamplesAreCounted) {
  ImuQueue queue;
  for (const int64_t t : {0, 5}) queue.Add({.t_ns = t});
  EXPECT_THAT(Times(queue.Take(0, 20)), ElementsAre(0, 5)) << "what there is";
  for (const int64_t t : {15, 10, 20, 25}) queue.Add({.t_ns = t});
  EXPECT_EQ(queue.counts().n_late, 3);
  EXPECT_THAT(Times(queue.Take(20, 25)), ElementsAre(20, 25));
  queue.Add({.t_ns = 30});
  EXPECT_EQ(queue.counts().n_late, 3);
}

TEST(ImuQueue, LaterMotionContainsLateSamples) {
  ImuQueue queue;
  for (const int64_t t : {0, 5}) queue.Add({.t_ns = t});
  EXPECT_THAT(Times(queue.Take(0, 20)), ElementsAre(0, 5));
  for (const int64_t t : {10, 15, 20, 25}) queue.Add({.t_ns = t});
  EXPECT_THAT(Times(queue.Take(0, 25)), ElementsAre(0, 5, 10, 15, 20, 25));
  EXPECT_THAT(Times(queue.Take(25, 25)), ElementsAre(25));
}

TEST(ImuQueue, ClockThatIsSetBackBeginsAgain) {
  ImuQueue queue;
  const int64_t later_ns = 10 * ImuQueue::kLongestDelay_ns;
  for (const int64_t t : {later_ns, later_ns + 5}) queue.Add({.t_ns = t});
  queue.Take(later_ns, later_ns + 5);
  for (const int64_t t : {0, 5, 10}) queue.Add({.t_ns = t});
  EXPECT_EQ(queue.newest_ns(), 10);
  EXPECT_THAT(Times(queue.Take(0, 10)), ElementsAre(0, 5, 10));
  EXPECT_EQ(queue.counts().n_late, 0);
}

TEST(ImuQueue, RatesAndForcesApart) {
  ImuQueue queue;
  queue.AddForce(0, Eigen::Vector3d(0.0, 0.0, 9.0));
  queue.AddRate(5, Eigen::Vector3d(1.0, 0.0, 0.0));
  EXPECT_FALSE(queue.Covers(5));
  queue.AddForce(10, Eigen::Vector3d(0.0, 0.0, 10.0));
  EXPECT_TRUE(queue.Covers(5));
  EXPECT_THAT(queue.Take(5, 5), ElementsAre(ImuSample{5, {1.0, 0.0, 0.0}, {0.0, 0.0, 9.5}}));
  EXPECT_THAT(ImuQueue().Take(0, 10), IsEmpty());
}

}  // namespace
}  // namespace plslam::robot
