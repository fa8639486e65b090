// SPDX-License-Identifier: BSD-3-Clause
#include "core/geometry/hypot.h"

#include <gtest/gtest.h>

#include <limits>
#include <random>

namespace plslam {
namespace {

TEST(Hypot, IsWithinOneUnitInTheLastPlaceOfTheCLibrary) {
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> mantissa(-1.0, 1.0);
  std::uniform_int_distribution<int> exponent(-60, 60);
  for (int i = 0; i < 100'000; ++i) {
    const double x = std::ldexp(mantissa(random), exponent(random));
    const double y = std::ldexp(mantissa(random), exponent(random));
    const double expected = std::hypot(x, y);
    EXPECT_LE(std::abs(Hypot(x, y) - expected), expected * std::numeric_limits<double>::epsilon()) << x << " " << y;
  }
}

// Of amd64. Here a fused multiply-add, and a correctly rounded result, are one unit less.
TEST(Hypot, BitsOfOnePair) {
  EXPECT_EQ(Hypot(0x1.b2be8de0e8a8p-8, 0x1.4875d176d9e86p-9), 0x1.d0baf0097147fp-8);
  EXPECT_EQ(Hypot(0x1.2890cc0eae498p+1, 0x1.aefbdee281dd1p+0), 0x1.6e96f03cbd462p+1);
}

TEST(Hypot, ZeroInfinityAndNan) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  EXPECT_EQ(Hypot(0.0, -0.0), 0.0);
  EXPECT_EQ(Hypot(-3.0, 0.0), 3.0);
  EXPECT_EQ(Hypot(3.0, -4.0), 5.0);
  EXPECT_EQ(Hypot(-kInfinity, 1.0), kInfinity);
  EXPECT_TRUE(std::isnan(Hypot(std::numeric_limits<double>::quiet_NaN(), 1.0)));
}

}  // namespace
}  // namespace plslam
