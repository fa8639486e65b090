// SPDX-License-Identifier: BSD-3-Clause
#include "core/robot/frame_numbers.h"

#include <gtest/gtest.h>

namespace plslam::robot {
namespace {

constexpr int64_t kT_ns = 1'764'000'000'000'000'000;
constexpr int64_t kPeriod_ns = 50'000'000;

TEST(FrameNumbers, ContinueAfterARestart) {
  FrameNumbers before, after;
  const int64_t last = (before.Next(kT_ns), before.Next(kT_ns + kPeriod_ns));
  EXPECT_GT(after.Next(kT_ns + 2 * kPeriod_ns), last);
  EXPECT_LT(last, int64_t{1} << 31);
}

TEST(FrameNumbers, AscendForRepeatedDecreasingAndLastTimes) {
  FrameNumbers numbers;
  int64_t last = numbers.Next(kT_ns);
  constexpr int64_t kAll_ns = 5'000'000 * (int64_t{1} << 31);
  for (const int64_t t_ns :
       {kT_ns, kT_ns - kPeriod_ns, int64_t{0}, kT_ns + kPeriod_ns, kT_ns / kAll_ns * kAll_ns + kAll_ns}) {
    const int64_t next = numbers.Next(t_ns);
    EXPECT_GT(next, last) << t_ns;
    last = next;
  }
}

}  // namespace
}  // namespace plslam::robot
