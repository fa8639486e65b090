// SPDX-License-Identifier: BSD-3-Clause
#include "tools/bridge/client_queue.h"

#include <gtest/gtest.h>

namespace plslam::bridge {
namespace {

OutFrame Frame(const std::string& name) { return {name, nullptr, true}; }

TEST(ClientQueue, SlowClientLosesImagesButNoPose) {
  ClientQueue queue;
  for (int i = 0; i < 100; ++i) {
    queue.PutNewest(1, Frame("image " + std::to_string(i)));
    queue.PutEvery(Frame("pose " + std::to_string(i)));
  }
  for (int i = 0; i < 100; ++i) EXPECT_EQ(queue.Take()->head, "pose " + std::to_string(i));
  EXPECT_EQ(queue.Take()->head, "image 99");
  EXPECT_FALSE(queue.Take());
  EXPECT_EQ(queue.n_dropped(), 99);
}

TEST(ClientQueue, NewestOfEachSubscriptionWaits) {
  ClientQueue queue;
  for (const uint32_t subscription : {1U, 2U, 1U, 3U}) {
    queue.PutNewest(subscription, Frame(std::to_string(subscription)));
  }
  queue.Forget(3);
  EXPECT_EQ(queue.Take()->head, "1");
  EXPECT_EQ(queue.Take()->head, "2");
  EXPECT_TRUE(queue.empty());
}

TEST(ClientQueue, ClientThatTakesNothingIsTooSlow) {
  ClientQueue queue;
  const auto payload = std::make_shared<const std::string>(1 << 20, 'x');
  for (int i = 0; i < 16; ++i) queue.PutEvery({"", payload, true});
  EXPECT_FALSE(queue.is_too_slow());
  queue.PutEvery(Frame("one more"));
  EXPECT_TRUE(queue.is_too_slow());
  queue.Take();
  EXPECT_FALSE(queue.is_too_slow());
}

}  // namespace
}  // namespace plslam::bridge
