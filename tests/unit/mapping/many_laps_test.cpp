// SPDX-License-Identifier: BSD-3-Clause
#include "tests/unit/mapping/many_laps.h"

#include <gtest/gtest.h>

#include <iostream>

#include "tests/support/lap_errors.h"
#include "tests/support/long_tests.h"

namespace plslam::mapping {
namespace {

/// The numbers of keyframes of a map: no limit, more than a lap has, and fewer.
class ManyLaps : public testing::TestWithParam<int> {};

// A thousand laps of a world that does not change; everyday tests run a part of them.
TEST_P(ManyLaps, LastLapIsAsAccurateAsTheSecond) {
  test::LapsOptions options;
  options.laps = test::LongTests() ? 1000 : 30;
  options.mapping.max_keyframes = GetParam();
  const test::LapsResult laps = test::RunLaps(options);
  std::cout << options.laps << " laps, at most " << laps.most.keyframes << " keyframes and " << laps.most.points
            << " points: live error of the second lap " << laps.live_m[1] << " m, of the last ones "
            << test::MeanOfLast(laps.live_m, 5) << " m, in the final map " << test::MeanOfLast(laps.final_m, 5)
            << " m\n";
  EXPECT_LE(test::MeanOfLast(laps.live_m, 5), 1.2 * laps.live_m[1]);
  EXPECT_LE(test::MeanOfLast(laps.final_m, 5), 1.2 * laps.live_m[1]);
}

INSTANTIATE_TEST_SUITE_P(Limit, ManyLaps, testing::Values(0, 50, 20));

}  // namespace
}  // namespace plslam::mapping
