// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>
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

constexpr int kLap_s = 15;

/// Errors of laps of a world with so many frames a second.
std::vector<double> Errors(const std::vector<OdometryFrame>& frames, int rate_hz) {
  std::vector<SE3> estimated, truth;
  for (const OdometryFrame& frame : frames) {
    estimated.push_back(frame.T_odom_l);
    truth.push_back(frame.T_w_l.value());
  }
  return ErrorsOfLaps(estimated, truth, static_cast<size_t>(kLap_s * rate_hz));
}

/// A line for each lap, and the frames that published a new body.
void PrintLaps(const std::vector<OdometryFrame>& live, const std::vector<double>& live_m,
               const std::vector<double>& final_m) {
  for (size_t lap = 0; lap < live_m.size(); ++lap)
    fmt::print("lap {}: live {:.1f} mm, final {:.1f} mm\n", lap + 1, 1e3 * live_m[lap], 1e3 * final_m[lap]);
  for (size_t i = 1; i < live.size(); ++i)
    if (live[i].n_bodies > live[i - 1].n_bodies) fmt::print("a body in frame {}\n", i);
}

struct LapsCase {
  const char* size;
  int max_keyframes;  ///< 0: no limit
  int laps;           ///< of the long test
};

class Laps : public testing::TestWithParam<LapsCase> {};

// Without a limit the map would have 112 keyframes. Everyday tests run ten laps of the second case, at half the rate.
TEST_P(Laps, LastLapIsAsAccurateAsTheSecond) {
  const LapsCase& test = GetParam();
  if (test.max_keyframes != 80 || test.laps != 100) PLSLAM_REQUIRE_LONG_TESTS();
  const int laps = LongTests() ? test.laps : 10;
  const int rate_hz = LongTests() ? 20 : 10;
  const auto dataset =
      OpenDataset(fmt::format("synthetic:room?size={}&loops={}&rate={}", test.size, laps, rate_hz), "");
  LoopRunOptions options;
  options.mapping.max_keyframes = test.max_keyframes;
  const LoopRun run = RunLoops(*dataset, loop::LoadPlaces({}, {}), options);
  const std::vector<double> live_m = Errors(run.slam.live, rate_hz);
  const std::vector<double> final_m = Errors(run.slam.final, rate_hz);
  std::cout << laps << " laps, " << run.slam.keyframes << " keyframes: live error of the second lap " << live_m[1]
            << " m, of the last ones " << MeanOfLast(live_m, 5) << " m, in the final map " << MeanOfLast(final_m, 5)
            << " m; ATE " << AbsoluteTrajectoryError(run.slam.live) << " and "
            << AbsoluteTrajectoryError(run.slam.final) << " m\n";
  PrintLaps(run.slam.live, live_m, final_m);
  EXPECT_EQ(LostFrames(run.slam.live), 0);
  EXPECT_EQ(run.slam.n_bodies, 0);
  EXPECT_LE(MeanOfLast(live_m, 5), 1.2 * live_m[1]);
  EXPECT_LE(MeanOfLast(final_m, 5), 1.2 * live_m[1]);
  EXPECT_LE(AbsoluteTrajectoryError(run.slam.final), 1.02 * AbsoluteTrajectoryError(run.slam.live));
}

// Three in ten posters, books and boxes are others, or elsewhere, from the third lap on.
TEST(ChangedRoom, RemainsWhereItWas) {
  constexpr int kLaps = 5, kRate_hz = 10;
  const auto dataset =
      OpenDataset(fmt::format("synthetic:room?size=376x240&rate={}&loops={}&changed_after=2", kRate_hz, kLaps), "");
  const LoopRun run = RunLoops(*dataset, loop::LoadPlaces({}, {}), {});
  const std::vector<double> live_m = Errors(run.slam.live, kRate_hz);
  const std::vector<double> final_m = Errors(run.slam.final, kRate_hz);
  PrintLaps(run.slam.live, live_m, final_m);
  EXPECT_EQ(LostFrames(run.slam.live), 0);
  EXPECT_EQ(run.slam.n_bodies, 0);
  for (int lap = 2; lap < kLaps; ++lap) EXPECT_LE(live_m[lap], 1.5 * live_m[1]) << lap;
  EXPECT_LE(MeanOfLast(final_m, 3), 1.2 * live_m[1]);
}

INSTANTIATE_TEST_SUITE_P(Limit, Laps,
                         testing::Values(LapsCase{"376x240", 0, 100}, LapsCase{"376x240", 80, 100},
                                         LapsCase{"376x240", 30, 100}, LapsCase{"752x480", 80, 40}),
                         [](const auto& tested) {
                           return fmt::format("Of{}Keyframes{}", tested.param.max_keyframes, tested.param.size);
                         });

}  // namespace
}  // namespace plslam::test
