// SPDX-License-Identifier: BSD-3-Clause
#include "tools/refine/remaining_time.h"

#include <gtest/gtest.h>

#include <cmath>

namespace plslam::refine {
namespace {

/// The excess of the cost falls by this factor in each iteration of each solve, of half a second: 12 iterations until it
/// falls by less than 1e-6.
constexpr double kFactor = 0.3;
constexpr int kIterations = 12;

double CostAfter(int iteration) { return 1000.0 * (1.0 + std::pow(kFactor, iteration)); }

TEST(RemainingTime, IsThatOfEqualSolves) {
  RemainingTime remaining(3);
  EXPECT_EQ(remaining.After(0, CostAfter(0), 0.0), 0.0) << "nothing is known yet";
  double elapsed_s = 0.0;
  for (int solve = 0; solve < 3; ++solve) {
    for (int i = solve == 0 ? 1 : 0; i <= kIterations; ++i) {
      if (i > 0) elapsed_s += 0.5;
      const double left_s = remaining.After(i, CostAfter(i), elapsed_s);
      if (i < 2 && solve == 0) continue;
      const double true_s = 0.5 * (3 * kIterations) - elapsed_s;
      // Two iterations do not determine the factor yet, and the first solve knows no other.
      EXPECT_NEAR(left_s, true_s, solve == 0 || i < 3 ? 6.0 : 1.5) << "solve " << solve << " iteration " << i;
    }
  }
}

TEST(RemainingTime, NeedsNoProgressOfTheCost) {
  RemainingTime remaining(1);
  remaining.After(0, 10.0, 0.0);
  // Rejected steps.
  const double first_s = remaining.After(1, 10.0, 1.0);
  const double second_s = remaining.After(2, 10.0, 2.0);
  EXPECT_GT(first_s, 0.0);
  EXPECT_TRUE(std::isfinite(first_s));
  EXPECT_LT(second_s, first_s);
  EXPECT_GE(remaining.After(0, 0.0, 3.0), 0.0) << "more solves than were expected";
}

}  // namespace
}  // namespace plslam::refine
