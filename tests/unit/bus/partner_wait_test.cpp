// SPDX-License-Identifier: BSD-3-Clause
#include "core/process/partner_wait.h"

#include <gtest/gtest.h>

namespace plslam::bus {
namespace {

TEST(PartnerWait, GivesUpWithoutSignsOfLife) {
  PartnerWait wait(5.0);
  EXPECT_FALSE(wait.GiveUp(100.0)) << "nothing is waited for";
  wait.Begin(3, 100.0);
  EXPECT_EQ(wait.awaited(), 3);
  EXPECT_FALSE(wait.GiveUp(104.9));
  EXPECT_TRUE(wait.GiveUp(105.0));
  EXPECT_EQ(wait.awaited(), std::nullopt);
  EXPECT_FALSE(wait.GiveUp(110.0)) << "it is reported once";
}

TEST(PartnerWait, SilenceIsReportedOnce) {
  PartnerWait wait(5.0);
  EXPECT_FALSE(wait.NoticeSilence(100.0)) << "nothing is waited for";
  wait.Begin(1, 100.0);
  EXPECT_FALSE(wait.NoticeSilence(101.9));
  EXPECT_TRUE(wait.NoticeSilence(102.1));
  EXPECT_FALSE(wait.NoticeSilence(103.0));
  PartnerWait heard(5.0);
  heard.OnSignOfLife(99.0);
  heard.Begin(1, 100.0);
  heard.OnSignOfLife(101.0);
  EXPECT_FALSE(heard.NoticeSilence(102.5));
  PartnerWait impatient(1.0);
  impatient.Begin(1, 100.0);
  EXPECT_FALSE(impatient.NoticeSilence(103.0)) << "the end of the wait is reported";
}

TEST(PartnerWait, WaitsUntilSignsOfLifeEnd) {
  PartnerWait wait(5.0);
  wait.Begin(3, 0.0);
  for (double now = 1.0; now < 60.0; now += 1.0) {
    wait.OnSignOfLife(now);
    EXPECT_FALSE(wait.GiveUp(now + 0.5)) << now;
  }
  EXPECT_FALSE(wait.GiveUp(63.9));
  EXPECT_TRUE(wait.GiveUp(64.0));
}

TEST(PartnerWait, EachWaitHasItsOwnTime) {
  PartnerWait wait(5.0);
  wait.OnSignOfLife(0.0);
  wait.Begin(1, 1.0);
  wait.End();
  EXPECT_EQ(wait.awaited(), std::nullopt);
  EXPECT_FALSE(wait.GiveUp(100.0));
  wait.Begin(2, 100.0);
  EXPECT_FALSE(wait.GiveUp(104.0)) << "the sign of life is old, the wait is not";
  EXPECT_TRUE(wait.GiveUp(105.0));
}

TEST(PartnerWait, WaitsAgainOnlyAfterASignOfLife) {
  PartnerWait wait(5.0);
  wait.Begin(1, 0.0);
  ASSERT_TRUE(wait.GiveUp(5.0));
  wait.Begin(2, 6.0);
  EXPECT_EQ(wait.awaited(), std::nullopt);
  wait.OnSignOfLife(7.0);
  EXPECT_EQ(wait.awaited(), std::nullopt) << "what was given up is past";
  wait.Begin(3, 8.0);
  EXPECT_EQ(wait.awaited(), 3);
}

TEST(PartnerWait, ZeroTimeDoesNotWait) {
  PartnerWait wait(0.0);
  wait.Begin(1, 2.0);
  EXPECT_TRUE(wait.GiveUp(2.0));
}

}  // namespace
}  // namespace plslam::bus
