// SPDX-License-Identifier: BSD-3-Clause
#include "tools/plslam/stall_watch.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace plslam::launcher {
namespace {

using std::chrono::seconds;
using testing::HasSubstr;

/// A run at a second after its begin.
class StallWatchTest : public testing::Test {
 protected:
  StallWatchTest() { watch_.Begin(Now()); }
  StallWatch::TimePoint Now() const { return StallWatch::TimePoint(seconds(1000 + t_s_)); }

  std::string LookAfter(int pass_s) {
    t_s_ += pass_s;
    return watch_.Look(signs_, Now());
  }
  /// The same while the viewer publishes a status every second.
  std::string TalkFor(int duration_s) {
    std::string stall;
    for (int i = 0; i < duration_s && stall.empty(); ++i) {
      signs_.viewer_heard_s += 1.0;
      stall = LookAfter(1);
    }
    return stall;
  }

  int t_s_ = 0;
  SignsOfLife signs_;
  StallWatch watch_;
};

TEST_F(StallWatchTest, NoPoseForTwoMinutesIsAStall) {
  EXPECT_EQ(TalkFor(120), "");
  ++signs_.map_version;
  EXPECT_THAT(TalkFor(1), "no pose for 120 s");
}

TEST_F(StallWatchTest, PosesAndWaitingForAFrameTimeAreNoStall) {
  ++signs_.poses;
  EXPECT_EQ(LookAfter(119), "");
  ++signs_.poses;
  EXPECT_EQ(LookAfter(119), "");
  signs_.waits_for_time = true;
  EXPECT_EQ(LookAfter(1000), "");
  signs_.waits_for_time = false;
  EXPECT_EQ(LookAfter(120), "");
  EXPECT_EQ(LookAfter(1), "no pose for 120 s");
}

TEST_F(StallWatchTest, SilentViewerAfterTheEndIsAStall) {
  EXPECT_EQ(LookAfter(100), "");
  signs_.stream_ended = true;
  EXPECT_EQ(LookAfter(100), "");
  EXPECT_EQ(TalkFor(60), "") << "it waits for the map";
  ++signs_.map_version;
  EXPECT_EQ(LookAfter(120), "") << "it writes";
  EXPECT_THAT(LookAfter(1), HasSubstr("the viewer has sent nothing for 120 s"));
}

TEST_F(StallWatchTest, ViewerThatNeverFinishesIsAStall) {
  signs_.stream_ended = true;
  EXPECT_EQ(TalkFor(300), "");
  ++signs_.map_version;
  EXPECT_EQ(TalkFor(300), "") << "there was something new";
  ++signs_.poses;
  EXPECT_EQ(TalkFor(300), "");
  EXPECT_THAT(TalkFor(10), HasSubstr("has not finished 300 s after the last pose and map"));
}

}  // namespace
}  // namespace plslam::launcher
