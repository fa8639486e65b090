// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <functional>
#include <random>

#include <gtest/gtest.h>
#include <opencv2/core.hpp>

#include "core/features/points/fast_score.h"
#include "core/features/points/orb_detector.h"
#include "tests/unit/features/texture.h"

namespace plslam {
namespace {

bool Less(const Corner& a, const Corner& b) { return a.y != b.y ? a.y < b.y : a.x < b.x; }

std::vector<Corner> Sorted(std::vector<Corner> corners) {
  std::sort(corners.begin(), corners.end(), Less);
  return corners;
}

/// A dark square on grey: its corners score `contrast`.
void DrawSquare(cv::Mat& image, int x, int y, int contrast) {
  image(cv::Rect(x, y, 12, 12)).setTo(image.at<uint8_t>(0, 0) - contrast);
}

TEST(CornerDetector, WeakCornersOnlyInCellsWithoutStrongOnes) {
  cv::Mat image(200, 300, CV_8UC1, cv::Scalar(120));
  DrawSquare(image, 40, 40, 60);
  DrawSquare(image, 56, 40, 10);    // same cells as the strong one
  DrawSquare(image, 200, 120, 10);  // alone
  CornerDetector detector;
  const std::vector<Corner> corners = detector.Detect(image, 20, 7, 3);
  int strong = 0;
  int weak_alone = 0;
  for (const Corner& c : corners) {
    if (c.response > 20) ++strong;
    if (c.x > 190 && c.response <= 20) ++weak_alone;
  }
  EXPECT_GE(strong, 4);
  EXPECT_GE(weak_alone, 4);
  EXPECT_TRUE(detector.Detect(image, 100, 90, 3).empty());
}

/// By the definition: all local maxima, then cell by cell.
std::vector<Corner> NaiveCorners(const cv::Mat& image, int threshold, int low_threshold, int margin) {
  constexpr int kCell_px = 32;
  cv::Mat scores;
  cv::Mat maxima;
  FastScores(image, scores);
  SuppressNonMaxima(scores, low_threshold + 1, maxima);
  const cv::Rect inside(margin, margin, image.cols - 2 * margin, image.rows - 2 * margin);
  std::vector<Corner> corners;
  for (int y = inside.y; y < inside.br().y; ++y) {
    for (int x = inside.x; x < inside.br().x; ++x) {
      const cv::Rect cell(margin + (x - margin) / kCell_px * kCell_px, margin + (y - margin) / kCell_px * kCell_px,
                          kCell_px, kCell_px);
      double best = 0.0;
      cv::minMaxLoc(maxima(cell & inside), nullptr, &best);
      const int score = maxima.at<uint8_t>(y, x);
      if (score > threshold || (score > 0 && best <= threshold)) corners.push_back({x, y, score});
    }
  }
  return corners;
}

TEST(CornerDetector, EqualsTheDefinition) {
  // Noise of growing contrast, so that some cells have weak corners only.
  cv::Mat image = test::RandomImage(213, 105, 8);
  for (int y = 0; y < image.rows; ++y) {
    for (int x = 0; x < image.cols; ++x) {
      image.at<uint8_t>(y, x) = static_cast<uint8_t>(100 + image.at<uint8_t>(y, x) * x / 500);
    }
  }
  CornerDetector detector;
  const std::vector<Corner> corners = detector.Detect(image, 12, 3, 16);
  const std::vector<Corner> expected = NaiveCorners(image, 12, 3, 16);
  ASSERT_EQ(corners.size(), expected.size());
  int weak = 0;
  for (size_t i = 0; i < corners.size(); ++i) {
    EXPECT_EQ(corners[i].x, expected[i].x) << "corner " << i;
    EXPECT_EQ(corners[i].y, expected[i].y) << "corner " << i;
    EXPECT_EQ(corners[i].response, expected[i].response) << "corner " << i;
    weak += corners[i].response <= 12 ? 1 : 0;
  }
  EXPECT_GT(weak, 10);
  EXPECT_GT(static_cast<int>(corners.size()) - weak, 10);
}

TEST(CornerDetector, KeepsTheMargin) {
  CornerDetector detector;
  for (const Corner& c : detector.Detect(test::RandomImage(100, 80, 5), 20, 7, 16)) {
    EXPECT_GE(c.x, 16);
    EXPECT_GE(c.y, 16);
    EXPECT_LT(c.x, 84);
    EXPECT_LT(c.y, 64);
  }
  EXPECT_TRUE(detector.Detect(test::RandomImage(32, 32, 5), 20, 7, 16).empty());
}

TEST(CornerDetector, SubPixelStaysInThePixel) {
  CornerDetector detector;
  const cv::Mat image = test::RenderTexture(200, 150, {});
  const std::vector<Corner> corners = detector.Detect(image, 10, 5, 3);
  ASSERT_GT(corners.size(), 20U);
  for (const Corner& c : corners) {
    const Eigen::Vector2d px = detector.SubPixel(c);
    EXPECT_LE((px - Eigen::Vector2d(c.x, c.y)).cwiseAbs().maxCoeff(), 0.5);
  }
}

TEST(SpreadCorners, ResultDoesNotDependOnTheOrderOfItsInput) {
  CornerDetector detector;
  std::vector<Corner> corners = detector.Detect(test::RandomImage(300, 200, 6), 20, 7, 3);
  ASSERT_GT(corners.size(), 500U);
  const std::vector<Corner> kept = Sorted(SpreadCorners(corners, 100, 300, 200));
  ASSERT_EQ(kept.size(), 100U);
  std::shuffle(corners.begin(), corners.end(), std::mt19937(7));
  const std::vector<Corner> again = Sorted(SpreadCorners(corners, 100, 300, 200));
  for (size_t i = 0; i < kept.size(); ++i) {
    EXPECT_EQ(kept[i].x, again[i].x);
    EXPECT_EQ(kept[i].y, again[i].y);
  }
}

TEST(SpreadCorners, AWeakRegionKeepsItsShareBesideAStrongOne) {
  std::vector<Corner> corners;
  for (int y = 0; y < 100; y += 4) {
    for (int x = 0; x < 200; x += 4) corners.push_back({x, y, x < 100 ? 200 : 10});
  }
  const std::vector<Corner> kept = SpreadCorners(corners, 100, 200, 100);
  ASSERT_EQ(kept.size(), 100U);
  const auto weak = std::count_if(kept.begin(), kept.end(), [](const Corner& c) { return c.x >= 100; });
  EXPECT_GE(weak, 35) << "of 100";
}

TEST(SpreadCorners, TakesTheBestOfACell) {
  const std::vector<Corner> corners = {{5, 5, 10}, {6, 6, 30}, {7, 5, 20}, {60, 60, 5}};
  const std::vector<Corner> kept = SpreadCorners(corners, 2, 100, 100);
  ASSERT_EQ(kept.size(), 2U);
  EXPECT_EQ(kept[0].response, 30);
}

TEST(SpreadCorners, QuotaOfZeroAndQuotaAboveTheCount) {
  const std::vector<Corner> corners = {{5, 5, 10}, {60, 60, 5}};
  EXPECT_TRUE(SpreadCorners(corners, 0, 100, 100).empty());
  EXPECT_EQ(SpreadCorners(corners, 10, 100, 100).size(), 2U);
  EXPECT_TRUE(SpreadCorners({}, 10, 100, 100).empty());
}

}  // namespace

namespace {

cv::Mat Image(const std::function<double(int, int)>& grey) {
  cv::Mat image(21, 21, CV_8UC1);
  for (int y = 0; y < image.rows; ++y) {
    for (int x = 0; x < image.cols; ++x) image.at<uint8_t>(y, x) = cv::saturate_cast<uint8_t>(grey(x, y));
  }
  return image;
}

TEST(CornerRatio, StraightEdgesHaveNoneInAnyDirection) {
  for (const double angle : {0.0, 0.4, 1.1, 1.57}) {
    const cv::Mat edge = Image([angle](int x, int y) {
      return 128.0 + 100.0 * std::tanh(0.7 * ((x - 10) * std::cos(angle) + (y - 10) * std::sin(angle)));
    });
    EXPECT_LT(CornerRatio(edge, 10, 10), 0.02) << "angle " << angle;
  }
}

TEST(CornerRatio, QuadrantIsACorner) {
  const cv::Mat corner = Image([](int x, int y) { return x > 10 && y > 10 ? 200.0 : 50.0; });
  EXPECT_GT(CornerRatio(corner, 10, 10), 0.3);
}

TEST(CornerRatio, DotIsTheSameAllRound) {
  const cv::Mat dot =
      Image([](int x, int y) { return 220.0 * std::exp(-0.2 * ((x - 10) * (x - 10) + (y - 10) * (y - 10))); });
  EXPECT_GT(CornerRatio(dot, 10, 10), 0.95);
}

TEST(CornerRatio, DoesNotDependOnContrast) {
  const cv::Mat strong = Image([](int x, int y) { return x > 10 && y > 10 ? 200.0 : 0.0; });
  const cv::Mat weak = Image([](int x, int y) { return x > 10 && y > 10 ? 20.0 : 0.0; });
  EXPECT_DOUBLE_EQ(CornerRatio(strong, 10, 10), CornerRatio(weak, 10, 10));
}

TEST(CornerRatio, UniformImageIsZeroNotNan) {
  EXPECT_EQ(CornerRatio(Image([](int, int) { return 77.0; }), 10, 10), 0.0);
}

}  // namespace
}  // namespace plslam
