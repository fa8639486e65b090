// SPDX-License-Identifier: BSD-3-Clause
#include "core/bus/delivery/message_size.h"

#include <gtest/gtest.h>

namespace plslam::bus {
namespace {

constexpr int64_t kSecond = 1'000'000'000;

TEST(MessageSize, FewLossesKeepMessagesLarge) {
  MessageSize size;
  for (int i = 0; i < 1000; ++i) {
    size.OnSent(60'000);
    if (i % 25 == 24) {
      EXPECT_FALSE(size.OnLost(1, i * kSecond)) << i;
    }
  }
  EXPECT_FALSE(size.IsSmall(1000 * kSecond));
}

TEST(MessageSize, ManyLossesSendPacketsForAWhile) {
  MessageSize size;
  for (int i = 0; i < 10; ++i) size.OnSent(60'000);
  EXPECT_FALSE(size.OnLost(2, kSecond)) << "a single burst";
  EXPECT_TRUE(size.OnLost(1, kSecond));
  EXPECT_EQ(size.percent(), 30);
  EXPECT_TRUE(size.IsSmall(30 * kSecond));
  EXPECT_FALSE(size.IsSmall(31 * kSecond));
  for (int i = 0; i < 10; ++i) size.OnSent(60'000);
  EXPECT_TRUE(size.OnLost(5, 31 * kSecond)) << "the link still loses packets";
  EXPECT_TRUE(size.IsSmall(90 * kSecond)) << "twice as long as before";
}

TEST(MessageSize, SmallMessagesDoNotCount) {
  MessageSize size;
  for (int i = 0; i < 1000; ++i) size.OnSent(1000);
  for (int i = 0; i < 3; ++i) size.OnSent(60'000);
  EXPECT_TRUE(size.OnLost(3, kSecond));
}

}  // namespace
}  // namespace plslam::bus
