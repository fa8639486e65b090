// SPDX-License-Identifier: BSD-3-Clause
#include "viewer_headless/captions.h"

#include <gtest/gtest.h>

#include "tests/unit/run/frame_poses.h"

namespace plslam::viewer {
namespace {

TEST(Progress, BeforeTheFirstFrame) {
  EXPECT_EQ(ProgressLine({}, {}), "frame 0  0.0/s  waiting");
  EXPECT_EQ(ProgressLine({}, {400, 0.0, 0, 0}), "frame 0/400  0.0/s  waiting");
}

TEST(Progress, ShowsTheNewestFrame) {
  Recorder recorder;
  recorder.AddPose(SomePose(0));
  FramePose pose = SomePose(1, TrackingState::kWeak);
  pose.keyframe_id = 0;
  pose.counts = {900, 100, 20, 3, 0};
  recorder.AddPose(pose);
  EXPECT_EQ(ProgressLine(recorder, {400, 18.26, 0, 0}),
            "frame 2/400  18.3/s  20 points  3 lines  keyframes 1  weak  gaps 0");
}

TEST(Progress, LossIsVisible) {
  Recorder recorder;
  FramePose pose = SomePose(0, TrackingState::kLost);
  pose.counts.skipped_frames = 4;
  recorder.AddPose(pose);
  EXPECT_EQ(ProgressLine(recorder, {-1, 1.0, 3, 2}),
            "frame 1  1.0/s  312 points  84 lines  keyframes 0  lost  lost 1  skipped 4  gaps 3 (2 repaired)");
}

TEST(Progress, Caption) {
  FramePose pose = SomePose(120);
  EXPECT_EQ(FrameCaption(pose), "frame 120  tracking  points 312/800  lines 84/120");
  pose.keyframe_id = 9;
  EXPECT_EQ(FrameCaption(pose), "frame 120  tracking  points 312/800  lines 84/120  keyframe 9");
}

}  // namespace
}  // namespace plslam::viewer
