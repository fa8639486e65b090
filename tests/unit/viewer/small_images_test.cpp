// SPDX-License-Identifier: BSD-3-Clause
#include "viewer_headless/report/small_images.h"

#include <cmath>
#include <stdexcept>

#include <gtest/gtest.h>
#include <opencv2/core.hpp>

#include "core/geometry/rectifier.h"
#include "tests/unit/geometry/test_rigs.h"

namespace plslam::viewer {
namespace {

cv::Mat SmoothImage(int width_px, int height_px) {
  cv::Mat image(height_px, width_px, CV_8UC1);
  for (int v = 0; v < height_px; ++v) {
    for (int u = 0; u < width_px; ++u) {
      image.at<uint8_t>(v, u) = static_cast<uint8_t>(128.0 + 60.0 * std::sin(0.05 * u) + 60.0 * std::cos(0.04 * v));
    }
  }
  return image;
}

void ExpectAsOfTheWholeImage(int width_px) {
  const RigCalibration rig = test::EurocRig();
  const Rectification rectification = Rectify(rig);
  const SmallRectifier small(rectification, rectification.right, "right", width_px);
  const cv::Mat image = SmoothImage(752, 480);
  const cv::Mat picture = small.Apply(image);
  const cv::Mat expected = Shrink(Rectifier(rig).RectifyRight(image), width_px);
  ASSERT_EQ(picture.size(), expected.size());
  cv::Mat difference;
  cv::absdiff(picture, expected, difference);
  EXPECT_LT(cv::mean(difference)[0], 0.7);
  double worst = 0.0;
  cv::minMaxLoc(difference, nullptr, &worst);
  EXPECT_LT(worst, 8.0);
}

TEST(SmallRectifier, AgreesWithShrinkingTheWholeImage) { ExpectAsOfTheWholeImage(512); }

TEST(SmallRectifier, BlocksAreMeansFirst) { ExpectAsOfTheWholeImage(256); }

TEST(SmallRectifier, SmallerImageKeepsItsSize) { ExpectAsOfTheWholeImage(1000); }

TEST(SmallRectifier, RectifiedAlready) {
  const Rectification rectification = Rectify(test::IdealRig());
  ASSERT_TRUE(rectification.identity);
  const cv::Mat image = SmoothImage(640, 480);
  const cv::Mat picture = SmallRectifier(rectification, rectification.left, "left", 256).Apply(image);
  EXPECT_EQ(picture.size(), cv::Size(256, 192));
  EXPECT_EQ(cv::norm(picture, Shrink(image, 256), cv::NORM_INF), 0.0);
}

TEST(SmallRectifier, AnotherSizeIsAnError) {
  const Rectification rectification = Rectify(test::EurocRig());
  const SmallRectifier small(rectification, rectification.left, "left", 256);
  EXPECT_THROW(small.Apply(SmoothImage(640, 480)), std::runtime_error);
}

}  // namespace
}  // namespace plslam::viewer
