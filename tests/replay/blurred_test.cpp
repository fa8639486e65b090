// SPDX-License-Identifier: BSD-3-Clause
#include <string>

#include <gtest/gtest.h>

#include "core/datasets/open_dataset.h"
#include "tests/support/slam_run.h"

namespace plslam::test {
namespace {

// Up to 200 degrees a second, with the shutter open for most of the time: hardly a sharp edge remains of a world that
// consists of edges.
TEST(Blurred, WhitewallIsTrackedInFastMotion) {
  const auto dataset = OpenDataset("synthetic:whitewall?size=376x240&frames=60&blur=0.8&speed=3&seed=4", "");
  const SlamRun run = RunSlam(*dataset, {}, {}, 1);
  EXPECT_EQ(LostFrames(run.live), 0);
  const double error_m = AbsoluteTrajectoryError(run.final);
  RecordProperty("ate_m", std::to_string(error_m));
  EXPECT_LT(error_m, 0.2) << "over 9 m";
}

// Few landmarks on a white wall: the motion of frame 22 needs more than ten iterations to converge.
TEST(WhiteWall, NoFrameIsLostToSlowConvergence) {
  const auto dataset = OpenDataset("synthetic:whitewall?seed=6", "");
  const SlamRun run = RunSlam(*dataset, {}, {}, 1);
  EXPECT_EQ(LostFrames(run.live), 0);
  EXPECT_LT(AbsoluteTrajectoryError(run.final), 0.01) << "over 13 m";
}

}  // namespace
}  // namespace plslam::test
