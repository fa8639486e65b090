// SPDX-License-Identifier: BSD-3-Clause
#include "camera/frame_order.h"

#include <gtest/gtest.h>

namespace plslam::camera {
namespace {

TEST(FrameOrder, FilesResumeAfterAFrame) {
  FrameOrder order;
  EXPECT_TRUE(order.IsNew(0, false));
  EXPECT_FALSE(order.has_resumed());
  order.OnBegin(500);
  EXPECT_TRUE(order.has_resumed());
  EXPECT_FALSE(order.IsNew(500, false));
  EXPECT_TRUE(order.IsNew(501, false));
  // Played again from the beginning.
  order.OnFrame(501);
  order.OnBegin(std::nullopt);
  EXPECT_TRUE(order.IsNew(0, false));
  EXPECT_TRUE(order.has_frames());
}

TEST(FrameOrder, LiveFramesFollowTheClock) {
  FrameOrder order;
  constexpr int64_t kTime_ns = 5'000'000'000;
  order.OnBegin(2 * kTime_ns);
  EXPECT_TRUE(order.IsNew(kTime_ns, true)) << "the clock of the previous process may have been wrong";
  EXPECT_FALSE(order.has_frames());
  order.OnFrame(kTime_ns);
  EXPECT_TRUE(order.has_frames());
  EXPECT_FALSE(order.IsNew(kTime_ns, true));
  EXPECT_TRUE(order.IsNew(kTime_ns + 1, true));
  EXPECT_FALSE(order.IsNew(kTime_ns - FrameOrder::kClockStep_ns + 1, true));
  EXPECT_TRUE(order.IsNew(kTime_ns - FrameOrder::kClockStep_ns, true)) << "the clock was set";
}

}  // namespace
}  // namespace plslam::camera
