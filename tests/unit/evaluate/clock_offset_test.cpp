// SPDX-License-Identifier: BSD-3-Clause
#include "tools/evaluate/clock_offset.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace plslam {
namespace {

constexpr int64_t kMaxClockGap_ns = 50'000'000;

SE3 OnCurve(double t_s) {
  return {ExpSO3({0.0, 0.4 * t_s, 0.0}), {std::sin(1.3 * t_s), 0.5 * std::sin(0.7 * t_s), std::cos(t_s)}};
}

// The camera at `rate_hz`, whose clock is `late_s` ahead of the true time.
Trajectory Along(double rate_hz, double late_s, double duration_s = 8.0) {
  Trajectory trajectory;
  for (int i = 0; i < duration_s * rate_hz; ++i) {
    const double t_s = i / rate_hz;
    trajectory.push_back({std::llround(1e9 * (t_s + late_s)), OnCurve(t_s)});
  }
  return trajectory;
}

TEST(ClockOffset, IsFound) {
  const Trajectory truth = Along(200.0, 0.0);
  for (const double late_s : {-0.0123, 0.0, 0.007, 0.031}) {
    const auto clock = FitClockOffset(Along(10.0, late_s), truth, Alignment::kSe3, kMaxClockGap_ns, 0.05);
    ASSERT_TRUE(clock) << late_s;
    EXPECT_NEAR(clock->offset_s, -late_s, 1.1e-4);
    EXPECT_LT(clock->ate_m, 2e-4);
    EXPECT_LE(clock->ate_m, clock->ate_now_m);
    EXPECT_GE(clock->ate_now_m, 0.1 * std::abs(late_s)) << "about a metre a second";
  }
}

TEST(ClockOffset, BeyondTheLimitThereIsNone) {
  const Trajectory truth = Along(200.0, 0.0);
  EXPECT_FALSE(FitClockOffset(Along(10.0, 0.2), truth, Alignment::kSe3, kMaxClockGap_ns, 0.05));
}

TEST(ClockOffset, OfACameraThatStandsIsNotInvented) {
  Trajectory truth = Along(200.0, 0.0);
  for (TrajectoryPose& pose : truth) pose.T_a_b = SE3();
  Trajectory estimate = Along(10.0, 0.0);
  for (TrajectoryPose& pose : estimate) pose.T_a_b = SE3();
  const auto clock = FitClockOffset(estimate, truth, Alignment::kSe3, kMaxClockGap_ns, 0.05);
  ASSERT_TRUE(clock);
  EXPECT_EQ(clock->offset_s, 0.0);
  EXPECT_EQ(clock->ate_m, 0.0);
}

TEST(ClockOffset, OfTooLittleIsNone) {
  const Trajectory truth = Along(200.0, 0.0);
  EXPECT_FALSE(FitClockOffset({}, truth, Alignment::kSe3, kMaxClockGap_ns, 0.05));
  EXPECT_FALSE(FitClockOffset(Along(10.0, 0.0), {}, Alignment::kSe3, kMaxClockGap_ns, 0.05));
  EXPECT_FALSE(FitClockOffset(Along(10.0, 0.0, 0.25), truth, Alignment::kSe3, kMaxClockGap_ns, 0.05))
      << "of three poses the first has no truth before it";
  EXPECT_FALSE(FitClockOffset(Along(10.0, 0.0), truth, Alignment::kSe3, kMaxClockGap_ns, 0.0));
}

TEST(ClockOffset, TimesAtTheEndOfAllNumbersAreNotMoved) {
  Trajectory estimate = Along(10.0, 0.0);
  estimate.back().t_ns = std::numeric_limits<int64_t>::max();
  EXPECT_FALSE(FitClockOffset(estimate, Along(200.0, 0.0), Alignment::kSe3, kMaxClockGap_ns, 0.05));
}

}  // namespace
}  // namespace plslam
