// SPDX-License-Identifier: BSD-3-Clause
#include "core/features/points/orb_detector.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <opencv2/core.hpp>

namespace plslam {
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
