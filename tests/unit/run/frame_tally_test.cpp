// SPDX-License-Identifier: BSD-3-Clause
#include "core/run/frame_tally.h"

#include <gtest/gtest.h>

namespace plslam {
namespace {

TEST(TrackingState, OnlyAnEstimatedPoseIsTracked) {
  EXPECT_FALSE(IsTracked(TrackingState::kInitialising, -1));
  EXPECT_TRUE(IsTracked(TrackingState::kInitialising, 0)) << "it founds the session";
  EXPECT_TRUE(IsTracked(TrackingState::kTracking, -1));
  EXPECT_TRUE(IsTracked(TrackingState::kWeak, -1));
  EXPECT_FALSE(IsTracked(TrackingState::kLost, 7));
  EXPECT_TRUE(IsTracked(TrackingState::kRecovered, -1));
  EXPECT_FALSE(IsTracked(static_cast<TrackingState>(9), 0));
  EXPECT_EQ(TrackingStateName(TrackingState::kLost), "lost");
  EXPECT_EQ(TrackingStateName(static_cast<TrackingState>(-1)), "unknown");
}

TEST(FrameTally, TotalIncludesLostAndSkippedFrames) {
  FrameTally tally;
  EXPECT_FALSE(tally.tracked_percent());
  for (int i = 0; i < 90; ++i) tally.Count(TrackingState::kInitialising, -1);
  EXPECT_EQ(tally.tracked_percent(), 0.0);
  for (int i = 0; i < 10; ++i) tally.Count(TrackingState::kTracking, -1);
  EXPECT_EQ(tally.tracked_percent(), 10.0);
  tally.Count(TrackingState::kLost, -1);
  tally.Count(TrackingState::kLost, -1, -1);
  tally.skipped = 40;
  tally.unreadable = 35;
  tally.unanswered = 25;
  EXPECT_EQ(tally.answered(), 100);
  EXPECT_EQ(tally.all(), 200);
  EXPECT_EQ(tally.tracked_percent(), 5.0);
}

TEST(FrameTally, HundredPerCentAreAllFrames) {
  EXPECT_EQ(TrackedPercent(9999, 10000), 99.9);
  EXPECT_EQ(TrackedPercent(10000, 10000), 100.0);
  EXPECT_EQ(TrackedPercent(3, 3), 100.0);
  EXPECT_EQ(TrackedPercent(29, 100), 29.0);
  EXPECT_FALSE(TrackedPercent(0, 0));
}

TEST(SentFrames, EndOfStreamCountsOverrideTheStatus) {
  SentFrames sent;
  sent.OnStatus(7, 2);
  FrameTally tally;
  tally.tracked = 4;
  tally.skipped = 1;
  EXPECT_EQ(sent.Unanswered(tally), 2);
  EXPECT_EQ(sent.unreadable(), 2);
  sent.OnStream(true, 9, 3);
  EXPECT_EQ(sent.Unanswered(tally), 4);
  EXPECT_EQ(sent.unreadable(), 3);
  sent.OnStatus(7, 2);
  EXPECT_EQ(sent.Unanswered(tally), 4);
  EXPECT_EQ(sent.unreadable(), 3);
}

TEST(SentFrames, LagCountsFromTheNewestPose) {
  SentFrames sent;
  EXPECT_EQ(sent.Behind(-1), 0);
  sent.OnStatus(100, 0);
  EXPECT_EQ(sent.Behind(-1), 100);
  EXPECT_EQ(sent.Behind(59), 40);
  EXPECT_EQ(sent.Behind(99), 0) << "however many of those before have no pose";
  EXPECT_EQ(sent.Behind(103), 0) << "poses are newer than the status";
  sent.OnStream(true, 120, 0);
  EXPECT_EQ(sent.Behind(99), 20);
}

}  // namespace
}  // namespace plslam
