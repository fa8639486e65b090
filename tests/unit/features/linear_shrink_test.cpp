// SPDX-License-Identifier: BSD-3-Clause
#include "core/features/image/linear_shrink.h"

#include <gtest/gtest.h>
#include <opencv2/imgproc.hpp>

#include "tests/unit/features/texture.h"

namespace plslam {
namespace {

void ExpectAsOpenCv(const cv::Mat& image, cv::Size size) {
  cv::Mat expected;
  cv::resize(image, expected, size, 0.0, 0.0, cv::INTER_LINEAR);
  LinearShrink shrink(image.size(), size);
  cv::Mat result;
  // Twice: no pixel of the first image may remain.
  shrink.Apply(cv::Mat(image.size(), CV_8UC1, cv::Scalar(77)), result);
  shrink.Apply(image, result);
  EXPECT_EQ(cv::countNonZero(result != expected), 0) << image.size() << " to " << size;
}

TEST(LinearShrink, EqualsOpenCvForManySizes) {
  for (int width = 8; width <= 60; ++width) {
    const cv::Mat image = test::RandomImage(width, 37, static_cast<unsigned>(width));
    for (int to = std::max(8, width / 2 + 1); to <= width; ++to) ExpectAsOpenCv(image, {to, 19 + to % 18});
  }
}

TEST(LinearShrink, EqualsOpenCvForLevelsOfAPyramid) {
  cv::Mat image = test::RandomImage(752, 480, 1);
  for (const cv::Size size : {cv::Size(627, 400), cv::Size(522, 333), cv::Size(435, 278), cv::Size(363, 231)}) {
    ExpectAsOpenCv(image, size);
    ExpectAsOpenCv(image >= 128, size);
    cv::resize(image, image, size, 0.0, 0.0, cv::INTER_LINEAR);
  }
}

TEST(LinearShrink, PartOfALargerImage) {
  ExpectAsOpenCv(test::RandomImage(100, 80, 2)(cv::Rect(13, 9, 61, 47)), {51, 39});
}

TEST(LinearShrink, RejectsUnsuitableSizes) {
  EXPECT_TRUE(LinearShrink::Fits({15, 15}, {8, 8}));
  EXPECT_FALSE(LinearShrink::Fits({16, 15}, {8, 8})) << "half";
  EXPECT_FALSE(LinearShrink::Fits({15, 40}, {8, 20})) << "half";
  EXPECT_FALSE(LinearShrink::Fits({20, 20}, {21, 20})) << "larger";
  EXPECT_FALSE(LinearShrink::Fits({10, 10}, {7, 9})) << "less than a block";
}

}  // namespace
}  // namespace plslam
