// SPDX-License-Identifier: BSD-3-Clause
#include "core/features/points/orb_descriptor.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include <gtest/gtest.h>
#include <opencv2/core.hpp>

#include "core/features/matching/hamming.h"
#include "tests/unit/features/texture.h"

namespace plslam {
namespace {

double NaiveAngle(const cv::Mat& image, int x, int y) {
  double m10 = 0.0;
  double m01 = 0.0;
  for (int v = -15; v <= 15; ++v) {
    for (int u = -15; u <= 15; ++u) {
      if (u * u + v * v > 15.5 * 15.5) continue;
      m10 += u * image.at<uint8_t>(y + v, x + u);
      m01 += v * image.at<uint8_t>(y + v, x + u);
    }
  }
  return std::atan2(m01, m10);
}

TEST(IntensityCentroidAngle, EqualsTheMoments) {
  const cv::Mat image = test::RenderTexture(120, 90, {});
  for (int y = 15; y < 90 - 16; y += 7) {
    for (int x = 15; x < 120 - 16; x += 5) {
      EXPECT_NEAR(std::remainder(IntensityCentroidAngle(image, x, y) - NaiveAngle(image, x, y), 2 * std::numbers::pi),
                  0.0, 2e-5);
    }
  }
}

TEST(IntensityCentroidAngle, FlatPatchHasNone) {
  EXPECT_EQ(IntensityCentroidAngle(cv::Mat(40, 40, CV_8UC1, cv::Scalar(255)), 20, 20), 0.0F);
}

TEST(AngleBin, CentredOnMultiplesAndClosed) {
  for (int bin = 0; bin < kOrbAngleBins; ++bin) {
    const double center = 2.0 * std::numbers::pi * bin / kOrbAngleBins;
    const double half = std::numbers::pi / kOrbAngleBins;
    for (const double turn : {-2.0 * std::numbers::pi, 0.0}) {
      EXPECT_EQ(AngleBin(static_cast<float>(center + turn)), bin);
      EXPECT_EQ(AngleBin(static_cast<float>(center + turn + 0.9 * half)), bin);
      EXPECT_EQ(AngleBin(static_cast<float>(center + turn - 0.9 * half)), bin);
    }
  }
}

TEST(TurnedPattern, StaysInThePatchForEveryTurn) {
  for (int bin = 0; bin < kOrbAngleBins; ++bin) {
    for (const BriefTest& t : TurnedPattern(bin)) {
      const int most = std::max({std::abs(t.x0), std::abs(t.y0), std::abs(t.x1), std::abs(t.y1)});
      EXPECT_LE(most, kOrbPatchRadius_px);
      EXPECT_TRUE(t.x0 != t.x1 || t.y0 != t.y1);
    }
  }
}

TEST(TurnedPattern, AQuarterTurnIsExact) {
  const BriefPattern& base = TurnedPattern(0);
  const BriefPattern& quarter = TurnedPattern(kOrbAngleBins / 4);
  for (size_t i = 0; i < base.size(); ++i) {
    EXPECT_EQ(quarter[i].x0, -base[i].y0);
    EXPECT_EQ(quarter[i].y0, base[i].x0);
  }
}

TEST(OrbDescriptor, BitsAreTheTestsOfThePattern) {
  const cv::Mat image = test::RandomImage(64, 48, 8);
  OrbDescriptor orb;
  for (const int bin : {0, 5, 31}) {
    const Descriptor d = orb.Compute(image, 30, 22, bin);
    const BriefPattern& pattern = TurnedPattern(bin);
    for (size_t i = 0; i < pattern.size(); ++i) {
      const BriefTest& t = pattern[i];
      const bool bit = image.at<uint8_t>(22 + t.y0, 30 + t.x0) < image.at<uint8_t>(22 + t.y1, 30 + t.x1);
      EXPECT_EQ((d[i / 64] >> (i % 64)) & 1U, bit ? 1U : 0U) << "bit " << i;
    }
  }
}

TEST(OrbDescriptor, FollowsAnImageTurnedByAQuarter) {
  const cv::Mat image = test::RenderTexture(101, 101, {});
  cv::Mat turned(101, 101, CV_8UC1);
  for (int y = 0; y < 101; ++y) {
    for (int x = 0; x < 101; ++x) turned.at<uint8_t>(x, 100 - y) = image.at<uint8_t>(y, x);
  }
  OrbDescriptor orb;
  const auto describe = [&orb](const cv::Mat& m) {
    return orb.Compute(m, 50, 50, AngleBin(IntensityCentroidAngle(m, 50, 50)));
  };
  EXPECT_LE(HammingDistance(describe(image), describe(turned)), 16);
}

TEST(BlurForBrief, EqualsTheWeightedSum) {
  const cv::Mat image = test::RandomImage(37, 23, 9);
  cv::Mat blurred;
  BlurForBrief(image, blurred);
  const std::array<int, 7> w = {18, 34, 48, 56, 48, 34, 18};
  const auto column = [&](int x, int y) {
    int sum = 128;
    for (int k = 0; k < 7; ++k) sum += w[k] * image.at<uint8_t>(std::clamp(y + k - 3, 0, 22), std::clamp(x, 0, 36));
    return sum >> 8;
  };
  for (int y = 0; y < 23; ++y) {
    for (int x = 0; x < 37; ++x) {
      int sum = 128;
      for (int k = 0; k < 7; ++k) sum += w[k] * column(x + k - 3, y);
      ASSERT_EQ(blurred.at<uint8_t>(y, x), sum >> 8) << x << ", " << y;
    }
  }
}

TEST(BlurForBrief, SaturatedAndTinyImages) {
  for (const cv::Size size : {cv::Size(1, 1), cv::Size(2, 5), cv::Size(40, 1)}) {
    cv::Mat blurred;
    BlurForBrief(cv::Mat(size, CV_8UC1, cv::Scalar(255)), blurred);
    EXPECT_EQ(cv::countNonZero(blurred == 255), size.area());
  }
}

TEST(HammingDistance, CountsBitsOneByOne) {
  std::mt19937_64 random(10);
  for (int n = 0; n < 100; ++n) {
    const Descriptor a = {random(), random(), random(), random()};
    const Descriptor b = {random(), random(), random(), random()};
    int bits = 0;
    for (size_t i = 0; i < 256; ++i) bits += (((a[i / 64] ^ b[i / 64]) >> (i % 64)) & 1U) != 0 ? 1 : 0;
    EXPECT_EQ(HammingDistance(a, b), bits);
    uint16_t distance = 0;
    HammingDistances(a, &b, 1, &distance);
    EXPECT_EQ(distance, bits);
  }
  EXPECT_EQ(HammingDistance({}, {~0ULL, ~0ULL, ~0ULL, ~0ULL}), 256);
}

}  // namespace
}  // namespace plslam
