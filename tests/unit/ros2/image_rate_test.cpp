// SPDX-License-Identifier: BSD-3-Clause
#include "ros2/image_rate.h"

#include <gtest/gtest.h>

#include <cmath>
#include <set>

namespace plslam::ros2 {
namespace {

/// Ten seconds at 20 Hz, of which every n-th image arrives.
ImageRate::Rates RatesWithEvery(const std::set<int>& of_five) {
  ImageRate rate;
  for (int i = 0; i < 200; ++i) {
    const int64_t jitter_ns = (i * 37 % 11) * 100'000;
    if (of_five.contains(i % 5)) rate.Add(50'000'000LL * i + jitter_ns, 0.05 * i);
  }
  return rate.Of(10.0);
}

TEST(Ros2ImageRate, LossesAreReportedWithTheBufferTheyNeed) {
  ImageRate::Rates rates = RatesWithEvery({0, 1});
  EXPECT_NEAR(rates.sent_hz, 20.0, 1.0);
  EXPECT_NEAR(rates.arrived_hz, 8.0, 0.3);
  EXPECT_EQ(LossSentence({20.0, 8.0}, 2 * 752 * 480, 212'992),
            "8 of 20 Hz arrive: receive buffer 212 kB, 2887 kB needed (sudo sysctl -w net.core.rmem_max=2887680)");
  EXPECT_EQ(LossSentence({20.0, 8.0}, 2 * 752 * 480, 16'000'000),
            "8 of 20 Hz arrive: images are lost between their driver and here");
}

TEST(Ros2ImageRate, MissingImagesAreCounted) {
  ImageRate rate;
  const std::set<int> missing{3, 4, 30, 77, 78, 79, 120};
  for (int i = 0; i < 200; ++i) {
    const int64_t jitter_ns = (i * 37 % 11) * 1'000'000;
    if (!missing.contains(i)) rate.Add(50'000'000LL * i + jitter_ns, 0.05 * i);
    if (i % 20 == 19) rate.CountMissing(rate.Of(0.05 * i));
  }
  EXPECT_EQ(rate.n_missing(), 7);
}

TEST(Ros2ImageRate, JitterIsNoLoss) {
  const ImageRate::Rates rates = RatesWithEvery({0, 1, 2, 3, 4});
  EXPECT_EQ(LossSentence(rates, 1, 0), "") << rates.arrived_hz << " of " << rates.sent_hz;
  EXPECT_EQ(LossSentence({}, 1, 0), "");
}

// With a longer exposure in the dark: from 30 to 15 Hz and back, twice.
TEST(Ros2ImageRate, CameraOfAnotherRateIsNoLoss) {
  constexpr int64_t kStep_ns = 33'333'333;
  ImageRate rate;
  int64_t n_bright = 0, n_dark = 0;
  for (int i = 0; i < 1200; ++i) {
    const bool is_dark = i % 600 > 300;
    const double now_s = 1e-9 * static_cast<double>(kStep_ns * i);
    if (!is_dark || i % 2 == 0) rate.Add(kStep_ns * i, now_s);
    if (i % 30 != 29) continue;
    const ImageRate::Rates rates = rate.Of(now_s);
    rate.CountMissing(rates);
    EXPECT_EQ(LossSentence(rates, 1, 0), "") << i << ": " << rates.arrived_hz << " of " << rates.sent_hz;
    n_bright += std::abs(rates.sent_hz - 30.0) < 1.0;
    n_dark += std::abs(rates.sent_hz - 15.0) < 1.0;
  }
  EXPECT_EQ(rate.n_missing(), 0);
  EXPECT_GE(n_bright, 16);
  EXPECT_GE(n_dark, 12);
}

TEST(Ros2ImageRate, RestartedCameraIsNoLoss) {
  ImageRate rate;
  for (int i = 0; i < 60; ++i) rate.Add(50'000'000LL * i + (i < 20 ? 0 : 100'000'000'000LL), 0.05 * i);
  const ImageRate::Rates rates = rate.Of(3.0);
  EXPECT_NEAR(rates.sent_hz, 20.0, 0.1);
  EXPECT_NEAR(rates.arrived_hz, 20.0, 0.1);
}

TEST(Ros2ImageRate, SmallBufferIsNamedAtTheStart) {
  EXPECT_EQ(
      SmallBufferSentence(212'992),
      "receive buffer 212 kB: a pair of 640 x 480 needs 2457 kB, and large images are lost with less (sudo sysctl -w "
      "net.core.rmem_max=16777216)");
  EXPECT_EQ(SmallBufferSentence(2'457'600), "");
}

}  // namespace
}  // namespace plslam::ros2
