// SPDX-License-Identifier: BSD-3-Clause
#include "tools/plslam/end_of_run.h"

#include <gtest/gtest.h>

namespace plslam::launcher {
namespace {

using std::chrono::seconds;
using Wait = EndOfRun::Wait;

/// A run whose frames are all sent and answered, and whose map is not complete.
class EndOfRunTest : public testing::Test {
 protected:
  EndOfRunTest() {
    signs_.stream_ended = signs_.tracker_finished = signs_.has_all_poses = true;
    signs_.poses = 40;
    signs_.map_version = 7;
  }

  Wait LookAfter(int pass_s) {
    t_s_ += pass_s;
    return end_.Look(signs_, EndOfRun::TimePoint(seconds(t_s_)));
  }

  int t_s_ = 1000;
  EndSigns signs_;
  EndOfRun end_;
};

TEST_F(EndOfRunTest, NoPauseOfASourceEndsARun) {
  signs_ = EndSigns();
  EXPECT_EQ(LookAfter(0), Wait::kStream);
  EXPECT_EQ(LookAfter(100000), Wait::kStream);
  signs_.stream_ended = signs_.source_sends = true;
  EXPECT_EQ(LookAfter(100000), Wait::kStream) << "readers lack frames";
  signs_.source_sends = false;
  EXPECT_EQ(LookAfter(1), Wait::kPoses);
}

TEST_F(EndOfRunTest, LastCommittedKeyframeEndsIt) {
  EXPECT_EQ(LookAfter(0), Wait::kMap);
  signs_.has_map = true;
  EXPECT_EQ(LookAfter(0), Wait::kNothing);
}

TEST_F(EndOfRunTest, SlowMapperIsAwaitedAsLongAsItWorks) {
  signs_.maps = true;
  for (int i = 0; i < 100; ++i) ASSERT_EQ(LookAfter(59), Wait::kMap) << i;
  signs_.maps = false;
  for (int i = 0; i < 100; ++i) {
    ++signs_.map_version;
    ASSERT_EQ(LookAfter(59), Wait::kMap) << "a version after a minute is progress";
  }
  EXPECT_EQ(LookAfter(60), Wait::kMap);
  EXPECT_EQ(LookAfter(1), Wait::kNothing) << "the keyframe was lost";
}

TEST_F(EndOfRunTest, FrameLostOnTheWayIsGivenUp) {
  signs_.has_map = true;
  signs_.tracker_finished = signs_.has_all_poses = false;
  EXPECT_EQ(LookAfter(0), Wait::kPoses);
  ++signs_.poses;
  EXPECT_EQ(LookAfter(20), Wait::kPoses);
  EXPECT_EQ(LookAfter(20), Wait::kPoses);
  EXPECT_EQ(LookAfter(1), Wait::kNothing);
}

TEST_F(EndOfRunTest, TrackerWhoseReadersLackItsMessages) {
  signs_.has_map = true;
  signs_.tracker_finished = false;
  EXPECT_EQ(LookAfter(0), Wait::kPoses);
  signs_.tracker_finished = true;
  EXPECT_EQ(LookAfter(0), Wait::kNothing);
}

TEST_F(EndOfRunTest, RunThatIsOverStaysOver) {
  signs_.has_map = true;
  EXPECT_EQ(LookAfter(0), Wait::kNothing);
  signs_ = EndSigns();
  EXPECT_EQ(LookAfter(1), Wait::kNothing) << "a player that was killed after its end begins again";
}

}  // namespace
}  // namespace plslam::launcher
