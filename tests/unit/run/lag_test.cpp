// SPDX-License-Identifier: BSD-3-Clause
#include "core/run/lag.h"

#include <gtest/gtest.h>

namespace plslam {
namespace {

TEST(PaceOf, SilenceCountsBeforeTheQueue) {
  EXPECT_EQ(PaceOf("running", 1.0, 4.0), Pace::kKeepsUp);
  EXPECT_EQ(PaceOf("running", 1.0, 5.0), Pace::kBehind);
  EXPECT_EQ(PaceOf("running", 3.0, 5.0), Pace::kSilent);
  EXPECT_EQ(PaceOf("running", 11.0, 5.0), Pace::kGone);
  EXPECT_EQ(PaceOf("stopping", 1.0, 5.0), Pace::kGone);
}

TEST(LagInFrames, CountsFromTheOldestKeyframeThatWaits) {
  // These of the frames with a pose, the newest first, are keyframes.
  const auto is_keyframe = [](int64_t i) { return i == 2 || i == 7 || i == 9; };
  EXPECT_EQ(LagInFrames(0, 20, is_keyframe), 0);
  EXPECT_EQ(LagInFrames(1, 20, is_keyframe), 3);
  EXPECT_EQ(LagInFrames(2, 20, is_keyframe), 8);
  EXPECT_EQ(LagInFrames(99, 20, is_keyframe), 10) << "earlier ones were in no queue";
  EXPECT_EQ(LagInFrames(1, 0, is_keyframe), 0);
}

}  // namespace
}  // namespace plslam
