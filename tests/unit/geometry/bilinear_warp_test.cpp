// SPDX-License-Identifier: BSD-3-Clause
#include "core/geometry/bilinear_warp.h"

#include <random>
#include <stdexcept>

#include <gtest/gtest.h>
#include <opencv2/imgproc.hpp>

namespace plslam {
namespace {

constexpr int kSub = BilinearWarp::kSubpixels;

cv::Mat Noise(int width, int height, uint32_t seed) {
  std::mt19937 random(seed);
  cv::Mat image(height, width, CV_8UC1);
  for (int v = 0; v < height; ++v) {
    for (int u = 0; u < width; ++u) image.at<uint8_t>(v, u) = static_cast<uint8_t>(random() & 255U);
  }
  return image;
}

/// A warp and the maps that make cv::remap do the same.
struct Twins {
  BilinearWarp warp;
  cv::Mat whole;
  cv::Mat fraction;

  Twins(int width, int height)
      : warp(width, height),
        whole(height, width, CV_16SC2, cv::Scalar::all(-2)),
        fraction(height, width, CV_16UC1, cv::Scalar(0)) {}

  void SetSource(int u, int v, int x, int y) {
    warp.SetSource(u, v, x, y);
    whole.at<cv::Vec2s>(v, u) = {static_cast<int16_t>(x / kSub), static_cast<int16_t>(y / kSub)};
    fraction.at<uint16_t>(v, u) = static_cast<uint16_t>(y % kSub * kSub + x % kSub);
  }

  int DifferentPixels(const cv::Mat& image) const {
    cv::Mat expected;
    cv::remap(image, expected, whole, fraction, cv::INTER_LINEAR, cv::BORDER_CONSTANT, cv::Scalar(0));
    return cv::countNonZero(warp.Apply(image) != expected);
  }
};

Twins Scattered(int width, int height, uint32_t seed) {
  Twins twins(width, height);
  std::mt19937 random(seed);
  for (int v = 0; v < height; ++v) {
    for (int u = 0; u < width; ++u) {
      const int x = static_cast<int>(random() % static_cast<uint32_t>((width - 1) * kSub + 1));
      const int y = static_cast<int>(random() % static_cast<uint32_t>((height - 1) * kSub + 1));
      if (random() % 8 != 0) twins.SetSource(u, v, x, y);
    }
  }
  return twins;
}

TEST(BilinearWarp, RandomPositionsAgreeWithOpenCv) {
  EXPECT_EQ(Scattered(211, 97, 1).DifferentPixels(Noise(211, 97, 2)), 0);
}

TEST(BilinearWarp, BlackAndWhiteDoNotOverflow) {
  EXPECT_EQ(Scattered(130, 70, 3).DifferentPixels(Noise(130, 70, 4) >= 128), 0);
}

TEST(BilinearWarp, EveryWeightOfEveryCorner) {
  // 2 x 2 pixels of 0 and 255, each combination, sampled at each of the 33 x 33 positions.
  Twins twins(33, 33);
  for (int v = 0; v < 33; ++v) {
    for (int u = 0; u < 33; ++u) twins.SetSource(u, v, u, v);
  }
  for (int corners = 0; corners < 16; ++corners) {
    cv::Mat image(33, 33, CV_8UC1, cv::Scalar(0));
    for (int i = 0; i < 4; ++i) image.at<uint8_t>(i / 2, i % 2) = (corners >> i & 1) != 0 ? 255 : 0;
    EXPECT_EQ(twins.DifferentPixels(image), 0) << "corners " << corners;
  }
}

TEST(BilinearWarp, LastRowAndColumn) {
  Twins twins(5, 4);
  for (int v = 0; v < 4; ++v) {
    for (int u = 0; u < 5; ++u) twins.SetSource(u, v, u * kSub, v * kSub);
  }
  const cv::Mat image = Noise(5, 4, 5);
  EXPECT_EQ(twins.DifferentPixels(image), 0);
  EXPECT_EQ(cv::countNonZero(twins.warp.Apply(image) != image), 0);
}

TEST(BilinearWarp, PartOfALargerImage) {
  const cv::Mat large = Noise(80, 60, 6);
  const cv::Mat part = large(cv::Rect(7, 5, 40, 30));
  EXPECT_EQ(Scattered(40, 30, 7).DifferentPixels(part), 0);
}

TEST(BilinearWarp, TooSmallToInterpolate) {
  EXPECT_THROW(BilinearWarp(1, 10), std::runtime_error);
  EXPECT_THROW(BilinearWarp(10, 1), std::runtime_error);
}

}  // namespace
}  // namespace plslam
