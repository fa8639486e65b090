// SPDX-License-Identifier: BSD-3-Clause
#include "core/features/feature_extractor.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include <opencv2/core.hpp>

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

/// Everything around the pixel was seen. What lies outside the image says nothing against it.
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
