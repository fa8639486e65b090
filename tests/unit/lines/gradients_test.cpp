// SPDX-License-Identifier: BSD-3-Clause
#include "core/features/image/gradients.h"

#include <algorithm>

#include <gtest/gtest.h>
#include <opencv2/core.hpp>

#include "tests/unit/lines/rendered_edges.h"

namespace plslam {
namespace {

constexpr int kAlong[5] = {1, 4, 6, 4, 1};
constexpr int kAcross[5] = {-1, -2, 0, 2, 1};

int Direct(const cv::Mat& image, int x, int y, const int* in_x, const int* in_y) {
  int sum = 0;
  for (int j = -2; j <= 2; ++j) {
    for (int i = -2; i <= 2; ++i) {
      const int column = std::clamp(x + i, 0, image.cols - 1);
      const int row = std::clamp(y + j, 0, image.rows - 1);
      sum += in_x[i + 2] * in_y[j + 2] * image.at<uint8_t>(row, column);
    }
  }
  return sum;
}

TEST(Gradients, EqualTheDirectSumAtEverySize) {
  for (const cv::Size size : {cv::Size(1, 1), cv::Size(1, 7), cv::Size(9, 1), cv::Size(3, 2), cv::Size(37, 23)}) {
    const cv::Mat image = test::NoiseImage(size, 128, 90, 3);
    Gradients g;
    ComputeGradients(image, g);
    ASSERT_EQ(g.dx.size(), size);
    for (int y = 0; y < size.height; ++y) {
      for (int x = 0; x < size.width; ++x) {
        ASSERT_EQ(g.dx.at<int16_t>(y, x), Direct(image, x, y, kAcross, kAlong)) << x << "," << y << " of " << size;
        ASSERT_EQ(g.dy.at<int16_t>(y, x), Direct(image, x, y, kAlong, kAcross)) << x << "," << y << " of " << size;
      }
    }
  }
}

TEST(Gradients, PartOfAnImageIsNotReadBeyondItsBorder) {
  const cv::Mat whole = test::NoiseImage({40, 30}, 128, 60, 5);
  const cv::Mat part = whole(cv::Rect(7, 5, 20, 15));
  Gradients of_part;
  Gradients of_copy;
  ComputeGradients(part, of_part);
  ComputeGradients(part.clone(), of_copy);
  EXPECT_EQ(cv::countNonZero(of_part.dx != of_copy.dx), 0);
  EXPECT_EQ(cv::countNonZero(of_part.dy != of_copy.dy), 0);
}

TEST(Gradients, StepHasTheStatedGain) {
  cv::Mat image(20, 20, CV_8UC1, cv::Scalar(50));
  image.colRange(10, 20).setTo(90);
  Gradients g;
  ComputeGradients(image, g);
  EXPECT_EQ(g.dx.at<int16_t>(10, 9), 40 * Gradients::kStepGain);
  EXPECT_EQ(g.dx.at<int16_t>(10, 10), 40 * Gradients::kStepGain);
  EXPECT_EQ(g.dy.at<int16_t>(10, 10), 0);
}

TEST(Gradients, EmptyImageGivesEmptyOnes) {
  Gradients g;
  ComputeGradients(cv::Mat(), g);
  EXPECT_TRUE(g.dx.empty());
}

}  // namespace
}  // namespace plslam
