// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <iostream>
#include <string>
#include <vector>

#include "core/datasets/open_dataset.h"
#include "loop_process/loop_service.h"
#include "tests/support/lap_errors.h"
#include "tests/support/long_tests.h"
#include "tests/support/loop_run.h"

namespace plslam::test {
namespace {

constexpr size_t kLap = 300;  // frames

std::vector<double> Errors(const std::vector<OdometryFrame>& frames) {
  std::vector<SE3> estimated, truth;
  for (const OdometryFrame& frame : frames) {
    estimated.push_back(frame.T_odom_l);
    truth.push_back(frame.T_w_l.value());
  }
  return ErrorsOfLaps(estimated, truth, kLap);
}

/// Limits of the map: none, twice a lap, less than a lap.
class Laps : public testing::TestWithParam<int> {};

// Everyday tests run ten laps with one of the limits; without it the map would have 112 keyframes.
TEST_P(Laps, LastLapIsAsAccurateAsTheSecond) {
  if (GetParam() != 80) PLSLAM_REQUIRE_LONG_TESTS();
  const int laps = LongTests() ? 100 : 10;
  const auto dataset = OpenDataset("synthetic:room?size=376x240&loops=" + std::to_string(laps), "");
  LoopRunOptions options;
  options.mapping.max_keyframes = GetParam();
  const LoopRun run = RunLoops(*dataset, loop::LoadPlaces({}, {}), options);
  const std::vector<double> live_m = Errors(run.slam.live);
  const std::vector<double> final_m = Errors(run.slam.final);
  std::cout << laps << " laps, " << run.slam.keyframes << " keyframes: live error of the second lap " << live_m[1]
            << " m, of the last ones " << MeanOfLast(live_m, 5) << " m, in the final map " << MeanOfLast(final_m, 5)
            << " m; ATE " << AbsoluteTrajectoryError(run.slam.live) << " and "
            << AbsoluteTrajectoryError(run.slam.final) << " m\n";
  EXPECT_EQ(LostFrames(run.slam.live), 0);
  EXPECT_LE(MeanOfLast(live_m, 5), 1.2 * live_m[1]);
  EXPECT_LE(MeanOfLast(final_m, 5), 1.2 * live_m[1]);
  EXPECT_LE(AbsoluteTrajectoryError(run.slam.final), 1.02 * AbsoluteTrajectoryError(run.slam.live));
}

INSTANTIATE_TEST_SUITE_P(Limit, Laps, testing::Values(0, 80, 30));

}  // namespace
}  // namespace plslam::test
