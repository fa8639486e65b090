// SPDX-License-Identifier: BSD-3-Clause
#include "camera/capture_health.h"

#include <gtest/gtest.h>

namespace plslam::camera {
namespace {

constexpr int64_t kMs = 1'000'000;

cv::Mat Image(int grey) { return {48, 64, CV_8UC1, cv::Scalar(grey)}; }

CapturedPair PairAt(int64_t left_ms, int64_t right_ms, int grey = 100) {
  return {{left_ms * kMs, Image(grey)}, {right_ms * kMs, Image(100)}};
}

TEST(CaptureHealth, RateAndSkewOfTheLastSeconds) {
  CaptureHealth health(0.0);
  EXPECT_EQ(health.rate_hz(), 0.0);
  for (int i = 0; i < 500; ++i) health.Add(PairAt(50 * i, 50 * i + (i < 300 ? 7 : -2)));
  EXPECT_NEAR(health.rate_hz(), 20.0, 1e-9);
  EXPECT_NEAR(health.skew_ms(), 2.0, 1e-9);
  EXPECT_EQ(health.pairs(), 500);
  EXPECT_EQ(health.missing(), 0);
}

TEST(CaptureHealth, HolesAreMissingFramesButNotAnOutage) {
  for (const double nominal_hz : {0.0, 20.0}) {
    CaptureHealth health(nominal_hz);
    for (int i = 0; i < 20; ++i) health.Add(PairAt(50 * i, 50 * i));
    health.Add(PairAt(1100, 1100));  // 1000 and 1050 are missing
    health.Interrupt();
    health.Add(PairAt(9000, 9000));
    EXPECT_EQ(health.missing(), 2) << nominal_hz;
  }
}

TEST(CaptureHealth, HalfTheRateIsHalfTheFramesMissing) {
  CaptureHealth health(20.0);
  for (int i = 0; i < 11; ++i) health.Add(PairAt(100 * i, 100 * i));
  EXPECT_EQ(health.missing(), 10);
}

TEST(CaptureHealth, WhiteAndBlackImagesAreCounted) {
  CaptureHealth health(0.0);
  health.Add(PairAt(0, 0, 255));
  health.Add(PairAt(50, 50, 0));
  health.Add(PairAt(100, 100, 0));
  health.Add(PairAt(150, 150, 60));
  EXPECT_EQ(health.overexposed(), 1);
  EXPECT_EQ(health.underexposed(), 2);
}

TEST(MeasureExposure, Shares) {
  cv::Mat image = Image(100);
  image.rowRange(0, 12).setTo(255);
  image.rowRange(12, 18).setTo(0);
  const Exposure exposure = MeasureExposure(image);
  EXPECT_NEAR(exposure.saturated, 0.25, 0.01);
  EXPECT_NEAR(exposure.black, 0.125, 0.05);
  EXPECT_EQ(MeasureExposure(cv::Mat()).black, 0.0);
}

}  // namespace
}  // namespace plslam::camera
