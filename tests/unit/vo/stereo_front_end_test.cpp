// SPDX-License-Identifier: BSD-3-Clause
#include "vo_process/stereo/stereo_front_end.h"

#include <gtest/gtest.h>

#include <algorithm>

#include <opencv2/imgproc.hpp>

namespace plslam::vo {
namespace {

RigCalibration Rig(int width, int height) {
  RigCalibration rig;
  rig.left.width_px = rig.right.width_px = width;
  rig.left.height_px = rig.right.height_px = height;
  rig.left.fx_px = rig.left.fy_px = rig.right.fx_px = rig.right.fy_px = 200.0;
  rig.left.cx_px = rig.right.cx_px = 0.5 * width;
  rig.left.cy_px = rig.right.cy_px = 0.5 * height;
  rig.right.T_b_cam = SE3(Eigen::Quaterniond::Identity(), Eigen::Vector3d(0.1, 0.0, 0.0));
  rig.baseline_m = 0.1;
  return rig;
}

StereoImages Uniform(int width, int height, int grey) {
  StereoImages images;
  images.left = cv::Mat(height, width, CV_8UC1, cv::Scalar(grey));
  images.right = images.left.clone();
  return images;
}

TEST(StereoFrontEnd, BlackAndOverexposedImagesHaveNoFeatures) {
  StereoFrontEnd front_end(Rig(320, 240), VoOptions());
  for (const int grey : {0, 128, 255}) {
    StageTimer timer;
    const StereoFeatures features = front_end.Process(Uniform(320, 240, grey), timer);
    EXPECT_EQ(features.points.size() + features.lines.size(), 0U) << "grey " << grey;
  }
}

/// Texture that the right camera sees 12 px further to the left.
StereoImages Textured(int width, int height) {
  cv::Mat noise(height, width + 12, CV_8UC1);
  cv::RNG(3).fill(noise, cv::RNG::UNIFORM, 0, 256);
  cv::GaussianBlur(noise, noise, {0, 0}, 2.0);
  cv::normalize(noise, noise, 0, 255, cv::NORM_MINMAX);
  StereoImages images;
  images.left = noise.colRange(0, width).clone();
  images.right = noise.colRange(12, width + 12).clone();
  return images;
}

MaskPolygon Rectangle(float x0, float y0, float x1, float y1) { return {{{x0, y0}, {x1, y0}, {x1, y1}, {x0, y1}}}; }

TEST(StereoFrontEnd, MaskedPartsHaveNeitherFeaturesNorPartners) {
  RigCalibration rig = Rig(320, 240);
  StageTimer timer;
  rig.left.mask = {Rectangle(0, 180, 319, 239)};
  rig.right.mask = {Rectangle(0, 0, 100, 239)};
  const StereoFeatures kept = StereoFrontEnd(rig, VoOptions()).Process(Textured(320, 240), timer);
  size_t n_with_depth = 0;
  for (const StereoPoint& point : kept.points) {
    EXPECT_LT(point.left.px.y(), 180.0);
    if (!point.HasDepth()) continue;
    ++n_with_depth;
    EXPECT_GT(point.left.px.x() - point.disparity_px, 100.0);
  }
  for (const StereoLine& line : kept.lines) {
    EXPECT_LT(std::max(line.left.segment.p.y(), line.left.segment.q.y()), 180.0);
  }
  EXPECT_GT(n_with_depth, 50U);
  const auto left_part = std::count_if(kept.points.begin(), kept.points.end(), [](const StereoPoint& point) {
    return point.left.px.x() < 100.0 && !point.HasDepth();
  });
  EXPECT_GT(left_part, 20) << "a left feature needs no right partner";
}

TEST(StereoFrontEnd, MaskedPartDoesNotUseUpThePointLimit) {
  VoOptions options;
  options.features.orb.max_points = 200;
  RigCalibration rig = Rig(320, 240);
  rig.left.mask = {Rectangle(0, 120, 319, 239)};
  StageTimer timer;
  EXPECT_GT(StereoFrontEnd(rig, options).Process(Textured(320, 240), timer).points.size(), 190U);
}

TEST(StereoFrontEnd, FrameMaskActsLikeARigMaskForOneFrame) {
  StageTimer timer;
  const StereoImages images = Textured(320, 240);
  RigCalibration rig = Rig(320, 240);
  StereoFrontEnd front_end(rig, VoOptions());
  const size_t n_before = front_end.Process(images, timer).points.size();
  const FrameMask mask{{Rectangle(0, 180, 319, 239)}, {Rectangle(0, 0, 100, 239)}};
  front_end.SetMask(mask);
  const StereoFeatures features = front_end.Process(images, timer);
  rig.left.mask = mask.left;
  rig.right.mask = mask.right;
  const StereoFeatures expected = StereoFrontEnd(rig, VoOptions()).Process(images, timer);
  ASSERT_EQ(features.points.size(), expected.points.size());
  for (size_t i = 0; i < features.points.size(); ++i) {
    EXPECT_EQ(features.points[i].left.px, expected.points[i].left.px);
    EXPECT_EQ(features.points[i].disparity_px, expected.points[i].disparity_px);
  }
  EXPECT_EQ(features.lines.size(), expected.lines.size());
  front_end.SetMask({});
  EXPECT_EQ(front_end.Process(images, timer).points.size(), n_before);
}

TEST(StereoFrontEnd, FrameMaskIsWarpedWithItsImage) {
  RigCalibration rig = Rig(320, 240);
  rig.left.model = rig.right.model = "radtan";
  rig.left.distortion = rig.right.distortion = {-0.2, 0.05, 0.0, 0.0};
  const StereoImages images = Textured(320, 240);
  StageTimer timer;
  StereoFrontEnd front_end(rig, VoOptions());
  const FrameMask mask{{Rectangle(0, 100, 319, 239)}, {}};
  front_end.SetMask(mask);
  const size_t n_points = front_end.Process(images, timer).points.size();
  rig.left.mask = mask.left;
  const size_t n_expected = StereoFrontEnd(rig, VoOptions()).Process(images, timer).points.size();
  EXPECT_GT(n_points, 50U);
  EXPECT_NEAR(static_cast<double>(n_points), static_cast<double>(n_expected), 0.05 * static_cast<double>(n_expected));
}

TEST(StereoFrontEnd, ImagesOfAnotherSizeAreRefusedWithBothSizes) {
  StereoFrontEnd front_end(Rig(320, 240), VoOptions());
  StageTimer timer;
  try {
    front_end.Process(Uniform(300, 240, 0), timer);
    FAIL() << "accepted";
  } catch (const std::runtime_error& error) {
    EXPECT_NE(std::string(error.what()).find("300"), std::string::npos) << error.what();
    EXPECT_NE(std::string(error.what()).find("320"), std::string::npos) << error.what();
  }
}

TEST(StereoFrontEnd, StagesAreTimedByTheGivenClock) {
  StereoFrontEnd front_end(Rig(320, 240), VoOptions());
  double now = 0.0;
  StageTimer timer([&now] { return now += 1.0; });
  front_end.Process(Uniform(320, 240, 0), timer);
  ASSERT_EQ(timer.stages().size(), 3U);
  EXPECT_EQ(timer.stages()[0].name, "rectify");
  EXPECT_EQ(timer.stages()[1].name, "features");
  EXPECT_EQ(timer.stages()[2].name, "stereo");
  EXPECT_DOUBLE_EQ(timer.stages()[0].ms, 1.0);
}

}  // namespace
}  // namespace plslam::vo
