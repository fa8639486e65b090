// SPDX-License-Identifier: BSD-3-Clause
#include "core/features/points/fast_score.h"

#include <algorithm>
#include <array>

#include <gtest/gtest.h>
#include <opencv2/core.hpp>

#include "tests/unit/features/texture.h"

namespace plslam {
namespace {

constexpr std::array<std::array<int, 2>, 16> kCircle = {{{0, -3},
                                                         {1, -3},
                                                         {2, -2},
                                                         {3, -1},
                                                         {3, 0},
                                                         {3, 1},
                                                         {2, 2},
                                                         {1, 3},
                                                         {0, 3},
                                                         {-1, 3},
                                                         {-2, 2},
                                                         {-3, 1},
                                                         {-3, 0},
                                                         {-3, -1},
                                                         {-2, -2},
                                                         {-1, -3}}};

/// By the definition: over all arcs of 9, the contrast of the least contrasting pixel.
int NaiveScore(const cv::Mat& image, int x, int y) {
  if (x < 3 || y < 3 || x >= image.cols - 3 || y >= image.rows - 3) return 0;
  int best = 0;
  for (const int sign : {1, -1}) {
    for (size_t first = 0; first < 16; ++first) {
      int least = 255;
      for (size_t k = 0; k < 9; ++k) {
        const auto& o = kCircle[(first + k) % 16];
        least = std::min(least, sign * (image.at<uint8_t>(y + o[1], x + o[0]) - image.at<uint8_t>(y, x)));
      }
      best = std::max(best, least);
    }
  }
  return best;
}

void ExpectNaiveScores(const cv::Mat& image) {
  cv::Mat scores;
  FastScores(image, scores);
  for (int y = 0; y < image.rows; ++y) {
    for (int x = 0; x < image.cols; ++x) {
      ASSERT_EQ(scores.at<uint8_t>(y, x), NaiveScore(image, x, y))
          << "at " << x << ", " << y << " of " << image.size();
    }
  }
}

TEST(FastScores, EqualTheDefinition) {
  ExpectNaiveScores(test::RandomImage(93, 41, 1));
  ExpectNaiveScores(test::RenderTexture(150, 60, {}));
}

TEST(FastScores, ImagesSmallerThanTheCircle) {
  for (const int side : {1, 2, 5, 6, 7, 8}) ExpectNaiveScores(test::RandomImage(side, side, 2));
}

TEST(FastScores, RegionOfALargerImage) {
  const cv::Mat image = test::RandomImage(80, 60, 3);
  ExpectNaiveScores(image(cv::Rect(11, 7, 50, 40)));
}

TEST(SuppressNonMaxima, OneMaximumPerPlateauAboveTheMinimum) {
  cv::Mat scores(9, 40, CV_8UC1, cv::Scalar(0));
  scores.at<uint8_t>(4, 10) = scores.at<uint8_t>(4, 11) = scores.at<uint8_t>(5, 10) = 50;
  scores.at<uint8_t>(4, 20) = 9;
  scores.at<uint8_t>(4, 30) = 10;
  cv::Mat maxima;
  SuppressNonMaxima(scores, 10, maxima);
  EXPECT_EQ(cv::countNonZero(maxima), 2) << maxima;
  EXPECT_EQ(maxima.at<uint8_t>(5, 10), 50);
  EXPECT_EQ(maxima.at<uint8_t>(4, 30), 10);
}

TEST(SuppressNonMaxima, KeptScoresAreMaximaOfRandomScores) {
  const cv::Mat scores = test::RandomImage(71, 33, 4);
  cv::Mat maxima;
  SuppressNonMaxima(scores, 100, maxima);
  int kept = 0;
  for (int y = 1; y < scores.rows - 1; ++y) {
    for (int x = 1; x < scores.cols - 1; ++x) {
      int best = 0;
      for (int v = -1; v <= 1; ++v) {
        for (int u = -1; u <= 1; ++u) best = std::max<int>(best, scores.at<uint8_t>(y + v, x + u));
      }
      const int score = scores.at<uint8_t>(y, x);
      if (maxima.at<uint8_t>(y, x) != 0) {
        ++kept;
        EXPECT_EQ(maxima.at<uint8_t>(y, x), best);
      } else if (score >= 100) {
        EXPECT_TRUE(score < best || std::count(scores.begin<uint8_t>(), scores.end<uint8_t>(), score) > 1);
      }
    }
  }
  EXPECT_GT(kept, 100);
}

}  // namespace
}  // namespace plslam
