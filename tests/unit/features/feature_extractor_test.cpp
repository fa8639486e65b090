// SPDX-License-Identifier: BSD-3-Clause
#include "core/features/feature_extractor.h"

#include <gtest/gtest.h>

#include "tests/unit/features/texture.h"
#include "vo_process/stereo/stereo_matcher.h"

namespace plslam::vo {
namespace {

const StereoCamera kExtractorCamera{
    .f_px = 300.0, .cx_px = 160.0, .cy_px = 120.0, .baseline_m = 0.1, .width_px = 320, .height_px = 240};

/// Texture with a few bright bars, so that it has features of both types.
cv::Mat Scene(double disparity_px) {
  cv::Mat image = test::RenderTexture(320, 240, {.shift_x_px = disparity_px, .gain = 0.4}, 9, 2.0);
  // Unequal in width, brightness and height: equal bars would be a repeated texture.
  const int shift = static_cast<int>(disparity_px);
  image(cv::Rect(60 - shift, 40, 14, 150)).setTo(230);
  image(cv::Rect(135 - shift, 25, 22, 140)).setTo(190);
  image(cv::Rect(230 - shift, 60, 9, 160)).setTo(15);
  return image;
}

FeatureOptions Only(const std::string& features) {
  FeatureOptions options;
  options.features = features;
  return options;
}

TEST(FeatureExtractor, GivesTheKindsAskedFor) {
  const cv::Mat image = Scene(0.0);
  const ImageFeatures points = FeatureExtractor(Only("points")).Extract(image);
  const ImageFeatures lines = FeatureExtractor(Only("lines")).Extract(image);
  const ImageFeatures both = FeatureExtractor(Only("both")).Extract(image);
  EXPECT_GT(points.points.size(), 50U);
  EXPECT_TRUE(points.lines.empty());
  EXPECT_TRUE(lines.points.empty());
  EXPECT_GE(lines.lines.size(), 6U);
  EXPECT_EQ(both.points.size(), points.points.size());
  EXPECT_EQ(both.lines.size(), lines.lines.size());
}

TEST(MatchStereo, KeepsEveryLeftFeatureInItsPlace) {
  const cv::Mat left = Scene(0.0);
  const cv::Mat right = Scene(10.0);
  FeatureExtractor extractor(Only("both"));
  const ImageFeatures features = extractor.Extract(left);
  const StereoFeatures stereo = MatchStereo(features, extractor.Extract(right), left, right, RowField(), {});
  ASSERT_EQ(stereo.points.size(), features.points.size());
  ASSERT_EQ(stereo.lines.size(), features.lines.size());
  int with_depth = 0;
  for (size_t i = 0; i < stereo.points.size(); ++i) {
    EXPECT_EQ(stereo.points[i].left.px, features.points[i].px);
    if (!stereo.points[i].HasDepth()) continue;
    ++with_depth;
    EXPECT_NEAR(stereo.points[i].disparity_px, 10.0, 1.0)
        << stereo.points[i].left.scale << " sigma " << stereo.points[i].sigma_disparity_px;
  }
  EXPECT_GT(with_depth, static_cast<int>(stereo.points.size()) / 3);
}

TEST(MatchStereo, ImagesOfOnePixel) {
  const cv::Mat pixel(1, 1, CV_8UC1, cv::Scalar(9));
  FeatureExtractor extractor(Only("both"));
  const StereoFeatures stereo = MatchStereo(extractor.Extract(pixel), {}, pixel, pixel, RowField(), {});
  EXPECT_TRUE(stereo.points.empty());
  EXPECT_TRUE(stereo.lines.empty());
}

TEST(AttachDepth, GivesBothKindsTheirDisparity) {
  const cv::Mat image = Scene(0.0);
  const cv::Mat depth(240, 320, CV_16UC1, cv::Scalar(3000));
  const StereoFeatures stereo =
      AttachDepth(FeatureExtractor(Only("both")).Extract(image), depth, 1000.0, kExtractorCamera, {});
  ASSERT_FALSE(stereo.points.empty());
  ASSERT_FALSE(stereo.lines.empty());
  for (const StereoPoint& p : stereo.points) EXPECT_NEAR(p.disparity_px, 10.0, 1e-9);
  for (const StereoLine& l : stereo.lines) EXPECT_NEAR(l.disparity_p_px, 10.0, 1e-6);
}

}  // namespace
}  // namespace plslam::vo
