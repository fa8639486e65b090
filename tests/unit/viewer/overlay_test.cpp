// SPDX-License-Identifier: BSD-3-Clause
#include "viewer_headless/overlay.h"

#include <gtest/gtest.h>

#include <limits>

namespace plslam::viewer {
namespace {

cv::Mat Grey() { return {120, 640, CV_8UC1, cv::Scalar(100)}; }

// Pixels of the image part that are not grey.
int ColouredPixels(const cv::Mat& picture, const cv::Rect& area) {
  int n = 0;
  for (int y = area.y; y < area.br().y; ++y) {
    for (int x = area.x; x < area.br().x; ++x) {
      const auto& p = picture.at<cv::Vec3b>(y, x);
      n += p[0] != p[1] || p[1] != p[2] ? 1 : 0;
    }
  }
  return n;
}

int ChangedPixels(const cv::Mat& picture) {
  int n = 0;
  for (int y = 0; y < 120; ++y) {
    for (int x = 0; x < picture.cols; ++x) n += picture.at<cv::Vec3b>(y, x) != cv::Vec3b(100, 100, 100) ? 1 : 0;
  }
  return n;
}

TEST(Overlay, NothingTrackedLeavesTheImageAndAddsACaption) {
  const cv::Mat picture = DrawOverlay(Grey(), {}, "caption");
  EXPECT_EQ(picture.type(), CV_8UC3);
  EXPECT_EQ(picture.cols, 640);
  EXPECT_GT(picture.rows, 140);
  EXPECT_EQ(ChangedPixels(picture), 0);
  EXPECT_NE(cv::norm(picture, DrawOverlay(Grey(), {}, "other")), 0.0);
}

TEST(Overlay, WhatTheMaskLeavesOutIsShaded) {
  cv::Mat mask(120, 640, CV_8UC1, cv::Scalar(255));
  mask.rowRange(90, 120).setTo(0);
  EXPECT_EQ(ColouredPixels(DrawOverlay(Grey(), {}, "caption", mask), {0, 0, 640, 120}), 30 * 640);
}

TEST(Overlay, NearPointsAreRedFarOnesBlueAndThoseWithoutDepthGrey) {
  const OverlayFeatures features{{{{20, 60}, 64.0F, 3}, {{60, 60}, 0.0F, 3}, {{100, 60}, -1.0F, 3}}, {}};
  const cv::Mat picture = DrawOverlay(Grey(), features, "");
  // The rings have a radius of 3.5 px.
  const auto strongest = [&](int x, int channel) {
    int value = 0;
    for (int dx = -5; dx <= 5; ++dx) value = std::max(value, int{picture.at<cv::Vec3b>(60, x + dx)[channel]});
    return value;
  };
  EXPECT_GT(strongest(20, 2), 200) << "red";
  EXPECT_LT(strongest(20, 0), 120);
  EXPECT_GT(strongest(60, 0), 200) << "blue";
  EXPECT_LT(strongest(60, 2), 120);
  EXPECT_EQ(ColouredPixels(picture, {90, 50, 20, 20}), 0) << "grey";
}

TEST(Overlay, SegmentsWithDepthAreColouredAndThickTheOthersDashedGrey) {
  const OverlayFeatures with_depth{{}, {{{10, 30}, {210, 30}, true, 5}}};
  const OverlayFeatures without{{}, {{{10, 30}, {210, 30}, false, 5}}};
  const cv::Mat thick = DrawOverlay(Grey(), with_depth, "");
  const cv::Mat dashed = DrawOverlay(Grey(), without, "");
  EXPECT_GT(ColouredPixels(thick, {0, 0, 640, 120}), 500);
  EXPECT_EQ(ColouredPixels(dashed, {0, 0, 640, 120}), 0);
  EXPECT_GT(ChangedPixels(dashed), 80);
  EXPECT_LT(ChangedPixels(dashed), 400);
}

TEST(Overlay, CoordinatesThatAreNotFiniteOrFarOutsideAreHarmless) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const float inf = std::numeric_limits<float>::infinity();
  OverlayFeatures features;
  for (const float bad : {nan, inf, -inf, 1e30F, -1e9F}) {
    features.points.push_back({{bad, 10}, 1.0F, 1});
    features.segments.push_back({{10, 10}, {10, bad}, false, 1});
    features.segments.push_back({{bad, 10}, {10, 10}, true, 1});
  }
  EXPECT_EQ(ChangedPixels(DrawOverlay(Grey(), features, "")), 0);
  const OverlayFeatures outside{{{{-100, -100}, nan, 1}}, {{{-500, -500}, {900, 900}, true, -5}}};
  EXPECT_FALSE(DrawOverlay(Grey(), outside, "").empty());
}

TEST(Overlay, SegmentOfNoLengthIsHarmless) {
  const OverlayFeatures features{{}, {{{10, 10}, {10, 10}, false, 0}, {{20, 20}, {20, 20}, true, 0}}};
  EXPECT_FALSE(DrawOverlay(Grey(), features, "").empty());
}

}  // namespace
}  // namespace plslam::viewer
