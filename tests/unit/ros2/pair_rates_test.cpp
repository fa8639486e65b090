// SPDX-License-Identifier: BSD-3-Clause
#include "ros2/pair_rates.h"

#include <gtest/gtest.h>

namespace plslam::ros2 {
namespace {

using robot::Side;

/// Ten seconds at 20 Hz: all images of one side, and four of five of the other.
PairRates RatesWithLosses(Side of_side) {
  PairRates rates;
  for (int i = 0; i < 200; ++i) {
    for (const Side side : {Side::kLeft, Side::kRight}) {
      if (side != of_side || i % 5 != 2) rates.Add(side, 50'000'000LL * i, 1000, 0.05 * i);
    }
  }
  return rates;
}

TEST(Ros2PairRates, WorseSideIsReported) {
  for (const Side side : {Side::kLeft, Side::kRight}) {
    PairRates rates = RatesWithLosses(side);
    const PairRates::Worse worse = rates.OfWorseSide(10.0);
    EXPECT_EQ(worse.side, side);
    EXPECT_NEAR(worse.rates.sent_hz, 20.0, 0.1);
    EXPECT_NEAR(worse.rates.arrived_hz, 16.0, 0.3);
    EXPECT_EQ(rates.CountMissing(10.0), 40);
    EXPECT_EQ(rates.CountMissing(10.0), 40) << "none is counted twice";
  }
}

TEST(Ros2PairRates, BetterSideShowsTheRateOfBoth) {
  // Every second image of the right side, whose own steps show no gap.
  PairRates rates;
  for (int i = 0; i < 200; ++i) {
    rates.Add(Side::kLeft, 50'000'000LL * i, 1000, 0.05 * i);
    if (i % 2 == 0) rates.Add(Side::kRight, 50'000'000LL * i, 1000, 0.05 * i);
  }
  const PairRates::Worse worse = rates.OfWorseSide(10.0);
  EXPECT_EQ(worse.side, Side::kRight);
  EXPECT_NEAR(worse.rates.sent_hz, 20.0, 0.1);
  EXPECT_NEAR(worse.rates.arrived_hz, 10.0, 0.1);
  EXPECT_EQ(rates.CountMissing(10.0), 99);
}

TEST(Ros2PairRates, LargestImagesAreTheSizeOfAPair) {
  PairRates rates;
  EXPECT_EQ(rates.pair_bytes(), 0);
  rates.Add(Side::kLeft, 0, 700, 0.0);
  rates.Add(Side::kRight, 0, 500, 0.0);
  EXPECT_EQ(rates.pair_bytes(), 1400);
}

}  // namespace
}  // namespace plslam::ros2
