// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>
#include <opencv2/core.hpp>

#include "core/features/feature_extractor.h"
#include "tests/unit/features/texture.h"
#include "vo_process/stereo/stereo_matcher.h"

namespace plslam {
namespace {

constexpr int kWidth_px = 60;
constexpr int kHeight_px = 50;
constexpr int kMargin_px = 8;

/// Points on a grid finer than pixels, that begins and ends outside the image.
ImageFeatures PointsEverywhere() {
  ImageFeatures features;
  for (double v = -3.0; v < kHeight_px + 3.0; v += 0.75) {
    for (double u = -3.0; u < kWidth_px + 3.0; u += 0.75) features.points.push_back({.px = {u, v}});
  }
  return features;
}

LineFeature Line(const Eigen::Vector2d& p, const Eigen::Vector2d& q) {
  LineFeature line;
  line.segment = {p, q};
  return line;
}

/// Returns whether everything around the pixel was seen. Pixels outside the image are ignored.
bool IsInsideSlowly(const cv::Mat& seen, const Eigen::Vector2d& px) {
  const int u = static_cast<int>(std::lround(px.x()));
  const int v = static_cast<int>(std::lround(px.y()));
  const cv::Rect image(0, 0, seen.cols, seen.rows);
  if (!image.contains({u, v})) return false;
  const cv::Rect around = cv::Rect(u - kMargin_px, v - kMargin_px, 2 * kMargin_px + 1, 2 * kMargin_px + 1) & image;
  return cv::countNonZero(seen(around)) == around.area();
}

cv::Mat SeenIn(const cv::Rect& area) {
  cv::Mat seen(kHeight_px, kWidth_px, CV_8UC1, cv::Scalar(0));
  seen(area).setTo(255);
  return seen;
}

TEST(FeatureMask, NoMaskKeepsEverything) {
  ImageFeatures features = PointsEverywhere();
  features.lines.push_back(Line({-5.0, 3.0}, {20.0, 900.0}));
  const size_t n_points = features.points.size();
  FeatureMask(cv::Mat()).RemoveOutside(features);
  EXPECT_EQ(features.points.size(), n_points);
  EXPECT_EQ(features.lines.size(), 1U);
}

TEST(FeatureMask, KeepsPointsWhoseSurroundingsWereSeen) {
  for (const cv::Rect& area : {cv::Rect(0, 0, kWidth_px, kHeight_px), cv::Rect(13, 7, 40, 30),
                               cv::Rect(0, 20, kWidth_px, 16), cv::Rect(0, 20, kWidth_px, 17)}) {
    const cv::Mat seen = SeenIn(area);
    ImageFeatures features = PointsEverywhere();
    const auto n_inside = std::count_if(features.points.begin(), features.points.end(),
                                        [&](const PointFeature& point) { return IsInsideSlowly(seen, point.px); });
    FeatureMask(seen).RemoveOutside(features);
    EXPECT_EQ(static_cast<std::ptrdiff_t>(features.points.size()), n_inside) << area;
    for (const PointFeature& point : features.points) {
      EXPECT_TRUE(IsInsideSlowly(seen, point.px)) << area << ": " << point.px.transpose();
    }
  }
}

TEST(FeatureMask, SegmentsNeedBothEndsAndTheMiddle) {
  cv::Mat seen = SeenIn(cv::Rect(0, 0, kWidth_px, kHeight_px));
  seen(cv::Rect(30, 0, 1, 10)).setTo(0);
  ImageFeatures features;
  features.lines = {Line({15.0, 30.0}, {45.0, 31.0}), Line({-1.0, 30.0}, {45.0, 31.0}),
                    Line({15.0, 30.0}, {60.0, 31.0}), Line({15.0, 5.0}, {45.0, 5.0})};
  FeatureMask(seen).RemoveOutside(features);
  ASSERT_EQ(features.lines.size(), 1U);
  EXPECT_EQ(features.lines[0].segment.q.y(), 31.0);
  EXPECT_EQ(features.lines[0].segment.q.x(), 45.0);
}

TEST(FeatureMask, NothingSeenAndNothingFound) {
  const FeatureMask mask(cv::Mat(kHeight_px, kWidth_px, CV_8UC1, cv::Scalar(0)));
  ImageFeatures none;
  mask.RemoveOutside(none);
  EXPECT_TRUE(none.points.empty() && none.lines.empty());
  ImageFeatures features = PointsEverywhere();
  mask.RemoveOutside(features);
  EXPECT_TRUE(features.points.empty()) << features.points.size();
}

}  // namespace
}  // namespace plslam

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

FeatureOptions Only(FeatureTypes features) {
  FeatureOptions options;
  options.features = features;
  return options;
}

TEST(FeatureExtractor, ExtractsTheRequestedFeatureTypes) {
  const cv::Mat image = Scene(0.0);
  const ImageFeatures points = FeatureExtractor(Only(FeatureTypes::kPoints)).Extract(image);
  const ImageFeatures lines = FeatureExtractor(Only(FeatureTypes::kLines)).Extract(image);
  const ImageFeatures both = FeatureExtractor(Only(FeatureTypes::kBoth)).Extract(image);
  EXPECT_GT(points.points.size(), 50U);
  EXPECT_TRUE(points.lines.empty());
  EXPECT_TRUE(lines.points.empty());
  EXPECT_GE(lines.lines.size(), 6U);
  EXPECT_EQ(both.points.size(), points.points.size());
  EXPECT_EQ(both.lines.size(), lines.lines.size());
}

TEST(MatchStereo, KeepsEveryLeftFeatureAtItsIndex) {
  const cv::Mat left = Scene(0.0);
  const cv::Mat right = Scene(10.0);
  FeatureExtractor extractor(Only(FeatureTypes::kBoth));
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
  FeatureExtractor extractor(Only(FeatureTypes::kBoth));
  const StereoFeatures stereo = MatchStereo(extractor.Extract(pixel), {}, pixel, pixel, RowField(), {});
  EXPECT_TRUE(stereo.points.empty());
  EXPECT_TRUE(stereo.lines.empty());
}

TEST(AttachDepth, GivesPointsAndLinesTheirDisparity) {
  const cv::Mat image = Scene(0.0);
  const cv::Mat depth(240, 320, CV_16UC1, cv::Scalar(3000));
  const StereoFeatures stereo =
      AttachDepth(FeatureExtractor(Only(FeatureTypes::kBoth)).Extract(image), depth, 1000.0, kExtractorCamera, {});
  ASSERT_FALSE(stereo.points.empty());
  ASSERT_FALSE(stereo.lines.empty());
  for (const StereoPoint& p : stereo.points) EXPECT_NEAR(p.disparity_px, 10.0, 1e-9);
  for (const StereoLine& l : stereo.lines) EXPECT_NEAR(l.disparity_p_px, 10.0, 1e-6);
}

}  // namespace
}  // namespace plslam::vo
