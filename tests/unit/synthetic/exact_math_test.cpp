// SPDX-License-Identifier: BSD-3-Clause
#include "core/datasets/synthetic/exact_math.h"

#include <cmath>

#include <gtest/gtest.h>

namespace plslam::synthetic {
namespace {

TEST(ExactMath, SineAndCosineAgreeWithTheLibrary) {
  for (int i = -2000; i <= 2000; ++i) {
    const double x = 0.013 * i;
    EXPECT_NEAR(Sin(x), std::sin(x), 2e-14) << "x " << x;
    EXPECT_NEAR(Cos(x), std::cos(x), 2e-14) << "x " << x;
  }
}

TEST(ExactMath, SineIsPinnedToTheLastBit) {
  EXPECT_EQ(Sin(0.0), 0.0);
  EXPECT_EQ(Sin(1.0), 0x1.aed548f090ceep-1);
}

TEST(ExactMath, RandomIsUniform) {
  Random random(5);
  double mean = 0.0;
  double square = 0.0;
  constexpr int kCount = 20000;
  for (int i = 0; i < kCount; ++i) {
    const double x = random.Uniform();
    ASSERT_GE(x, 0.0);
    ASSERT_LT(x, 1.0);
    mean += x / kCount;
    square += x * x / kCount;
  }
  EXPECT_NEAR(mean, 0.5, 0.01);
  EXPECT_NEAR(square, 1.0 / 3.0, 0.01);
}

}  // namespace
}  // namespace plslam::synthetic
