// SPDX-License-Identifier: BSD-3-Clause
#include "core/accuracy/consistency.h"

#include <gtest/gtest.h>

#include <cmath>

namespace plslam::evaluate {
namespace {

TEST(Statistics, ByHand) {
  const Statistics s = Summarise({4.0, 0.0, 3.0, 1.0});
  EXPECT_EQ(s.n, 4);
  EXPECT_DOUBLE_EQ(s.rmse, std::sqrt(26.0 / 4.0));
  EXPECT_DOUBLE_EQ(s.mean, 2.0);
  EXPECT_DOUBLE_EQ(s.median, 2.0);
  EXPECT_DOUBLE_EQ(s.max, 4.0);
  EXPECT_DOUBLE_EQ(Summarise({5.0, 1.0, 2.0}).median, 2.0);
}

TEST(Statistics, NoneAndOneValue) {
  EXPECT_EQ(Summarise({}).n, 0);
  EXPECT_EQ(Summarise({}).rmse, 0.0);
  EXPECT_EQ(Summarise({2.5}).rmse, 2.5);
  EXPECT_EQ(Summarise({2.5}).median, 2.5);
}

TEST(Statistics, ChiSquareQuantilesMatchPrintedTables) {
  EXPECT_NEAR(ChiSquareQuantile(6, -1.959964), 1.2373, 0.035);
  EXPECT_NEAR(ChiSquareQuantile(6, 1.959964), 14.4494, 0.02);
  EXPECT_NEAR(ChiSquareQuantile(60, -1.959964), 40.4817, 0.01);
  EXPECT_NEAR(ChiSquareQuantile(60, 1.959964), 83.2977, 0.01);
}

}  // namespace
}  // namespace plslam::evaluate
