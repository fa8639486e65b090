// SPDX-License-Identifier: BSD-3-Clause
#include "vo_process/stereo/row_search.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "tests/unit/features/texture.h"

namespace plslam::vo {
namespace {

/// Normalised correlation of the 11x11 patches at (u, v) and (w, v), the textbook way.
double Correlation(const cv::Mat& left, const cv::Mat& right, int u, int w, int v) {
  double sl = 0, sr = 0, sll = 0, srr = 0, slr = 0;
  for (int y = -5; y <= 5; ++y) {
    for (int x = -5; x <= 5; ++x) {
      const double l = left.at<uint8_t>(v + y, u + x);
      const double r = right.at<uint8_t>(v + y, w + x);
      sl += l, sr += r, sll += l * l, srr += r * r, slr += l * r;
    }
  }
  const double n = 121.0;
  return (slr - sl * sr / n) / std::sqrt((sll - sl * sl / n) * (srr - sr * sr / n));
}

TEST(RowSearch, EqualsTheTextbookCorrelation) {
  const cv::Mat left = test::RandomImage(140, 60, 1);
  const cv::Mat right = test::RandomImage(140, 60, 2);
  const HalvedPair pair(left, right);
  RowSearch search(pair);
  for (const int u : {5, 20, 70, 134}) {
    for (const int v : {5, 30, 54}) {
      const auto found = search.Find({static_cast<double>(u), static_cast<double>(v)}, 1.0, 0.0, 50.0);
      std::vector<double> scores;
      for (int d = 0; d <= std::min(50, u - 5); ++d) scores.push_back(Correlation(left, right, u, u - d, v));
      const auto best = std::max_element(scores.begin(), scores.end()) - scores.begin();
      if (scores[best] <= 0.0) {
        EXPECT_FALSE(found);
        continue;
      }
      double second = 0.0;
      for (int d = 0; d < static_cast<int>(scores.size()); ++d) {
        if (std::abs(d - static_cast<int>(best)) >= 3) second = std::max(second, scores[d]);
      }
      ASSERT_TRUE(found) << u << ", " << v;
      EXPECT_EQ(found->disparity_px, best);
      EXPECT_NEAR(found->correlation, scores[best], 1e-5);
      EXPECT_NEAR(found->second_correlation, second, 1e-5);
    }
  }
}

TEST(RowSearch, FindsAShiftAtEveryScaleAndExposure) {
  const cv::Mat left = test::RenderTexture(240, 100, {.gain = 0.5}, 5, 2.0);
  const cv::Mat right = test::RenderTexture(240, 100, {.shift_x_px = 24.0}, 5, 2.0);
  const HalvedPair pair(left, right);
  RowSearch search(pair);
  for (const double scale : {1.0, 2.0, 4.0}) {
    const auto found = search.Find({150.0, 50.0}, scale, 0.5, 100.0);
    ASSERT_TRUE(found);
    EXPECT_NEAR(found->disparity_px, 24.0, scale);
    EXPECT_GT(found->correlation, 0.98);
  }
}

TEST(RowSearch, RepeatedTextureHasASecondBestAsGood) {
  cv::Mat comb(60, 200, CV_8UC1);
  for (int y = 0; y < 60; ++y) {
    for (int x = 0; x < 200; ++x) comb.at<uint8_t>(y, x) = static_cast<uint8_t>(40 + 12 * (x % 16) + y % 5);
  }
  const HalvedPair pair(comb, comb);
  RowSearch search(pair);
  const auto found = search.Find({150.0, 30.0}, 1.0, 0.0, 100.0);
  ASSERT_TRUE(found);
  EXPECT_NEAR(found->second_correlation, found->correlation, 1e-6);
}

TEST(RowSearch, FlatBorderAndEmptyRange) {
  const cv::Mat flat(60, 80, CV_8UC1, cv::Scalar(7));
  const HalvedPair flat_pair(flat, flat);
  EXPECT_FALSE(RowSearch(flat_pair).Find({40, 30}, 1.0, 0.0, 30.0));
  const cv::Mat image = test::RandomImage(80, 60, 3);
  const HalvedPair pair(image, image);
  RowSearch search(pair);
  EXPECT_FALSE(search.Find({2, 30}, 1.0, 0.0, 30.0));
  EXPECT_FALSE(search.Find({40, 57}, 1.0, 0.0, 30.0));
  EXPECT_FALSE(search.Find({10, 30}, 1.0, 20.0, 30.0));
}

}  // namespace
}  // namespace plslam::vo
