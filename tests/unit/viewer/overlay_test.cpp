// SPDX-License-Identifier: BSD-3-Clause
#include <limits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "viewer_headless/overlay.h"

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

TEST(Overlay, NothingTrackedAddsOnlyACaption) {
  const cv::Mat picture = DrawOverlay(Grey(), {}, "caption");
  EXPECT_EQ(picture.type(), CV_8UC3);
  EXPECT_EQ(picture.cols, 640);
  EXPECT_GT(picture.rows, 140);
  EXPECT_EQ(ChangedPixels(picture), 0);
  EXPECT_NE(cv::norm(picture, DrawOverlay(Grey(), {}, "other")), 0.0);
}

TEST(Overlay, MaskedPixelsAreShaded) {
  cv::Mat mask(120, 640, CV_8UC1, cv::Scalar(255));
  mask.rowRange(90, 120).setTo(0);
  EXPECT_EQ(ColouredPixels(DrawOverlay(Grey(), {}, "caption", mask), {0, 0, 640, 120}), 30 * 640);
}

TEST(Overlay, ColoursOfNearFarAndUnknownPoints) {
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

TEST(Overlay, StylesOfSegmentsWithAndWithoutDepth) {
  const OverlayFeatures with_depth{{}, {{{10, 30}, {210, 30}, 4, 4, 5}}};
  const OverlayFeatures without{{}, {{{10, 30}, {210, 30}, -1, -1, 5}}};
  const cv::Mat thick = DrawOverlay(Grey(), with_depth, "");
  const cv::Mat dashed = DrawOverlay(Grey(), without, "");
  EXPECT_GT(ColouredPixels(thick, {0, 0, 640, 120}), 500);
  EXPECT_EQ(ColouredPixels(dashed, {0, 0, 640, 120}), 0);
  EXPECT_GT(ChangedPixels(dashed), 80);
  EXPECT_LT(ChangedPixels(dashed), 400);
}

TEST(Overlay, NonFiniteAndFarOutsideCoordinates) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const float inf = std::numeric_limits<float>::infinity();
  OverlayFeatures features;
  for (const float bad : {nan, inf, -inf, 1e30F, -1e9F}) {
    features.points.push_back({{bad, 10}, 1.0F, 1});
    features.segments.push_back({{10, 10}, {10, bad}, -1, -1, 1});
    features.segments.push_back({{bad, 10}, {10, 10}, 4, 4, 1});
  }
  EXPECT_EQ(ChangedPixels(DrawOverlay(Grey(), features, "")), 0);
  const OverlayFeatures outside{{{{-100, -100}, nan, 1}}, {{{-500, -500}, {900, 900}, 4, 4, -5}}};
  EXPECT_FALSE(DrawOverlay(Grey(), outside, "").empty());
}

TEST(Overlay, SegmentOfNoLengthIsHarmless) {
  const OverlayFeatures features{{}, {{{10, 10}, {10, 10}, -1, -1, 0}, {{20, 20}, {20, 20}, 4, 4, 0}}};
  EXPECT_FALSE(DrawOverlay(Grey(), features, "").empty());
}

}  // namespace

namespace {

const cv::Mat kImage(4, 4, CV_8UC1, cv::Scalar(0));

FramePose PoseOf(FrameId frame_id) {
  FramePose pose;
  pose.frame_id = frame_id;
  return pose;
}

TEST(OverlayQueue, PartsInAnyOrderMakeAPicture) {
  OverlayQueue queue(5);
  queue.AddPose(PoseOf(10));
  queue.AddImage(10, kImage);
  EXPECT_FALSE(queue.Next());
  EXPECT_THAT(queue.lacking(), testing::ElementsAre(10));
  queue.AddFeatures(10, {{{{1, 1}, 2.0F, 3}}, {}});
  const auto ready = queue.Next();
  ASSERT_TRUE(ready);
  EXPECT_EQ(ready->pose.frame_id, 10);
  EXPECT_EQ(ready->features.points.size(), 1u);
  EXPECT_THAT(queue.lacking(), testing::IsEmpty());
  queue.AddImage(10, kImage);
  EXPECT_FALSE(queue.Next()) << "each picture once";
}

TEST(OverlayQueue, OnlyEveryNthFrameIsWanted) {
  EXPECT_TRUE(OverlayQueue(5).Wants(0));
  EXPECT_FALSE(OverlayQueue(5).Wants(4));
  EXPECT_FALSE(OverlayQueue(5).Wants(-5));
  EXPECT_FALSE(OverlayQueue(0).Wants(0));
  OverlayQueue queue(5);
  queue.AddPose(PoseOf(4));
  queue.AddFeatures(4, {});
  queue.AddImage(4, kImage);
  EXPECT_FALSE(queue.Next());
  EXPECT_THAT(queue.lacking(), testing::IsEmpty());
}

TEST(OverlayQueue, PicturesOfAHundredFramesWaitForTheirFeatures) {
  OverlayQueue queue(1);
  for (int i = 0; i < 100; ++i) {
    queue.AddPose(PoseOf(i));
    queue.AddImage(i, kImage);
  }
  for (int i = 0; i < 100; ++i) {
    queue.AddFeatures(i, {});
    const auto ready = queue.Next();
    ASSERT_TRUE(ready);
    EXPECT_EQ(ready->pose.frame_id, i);
  }
}

TEST(OverlayQueue, OldIncompleteFramesAreDropped) {
  OverlayQueue queue(1);
  for (int i = 0; i < 2000; ++i) queue.AddPose(PoseOf(i));
  EXPECT_EQ(queue.lacking().size(), 2000u);
  EXPECT_FALSE(queue.first_image());
  for (const int i : {0, 1999}) {
    queue.AddFeatures(i, {});
    queue.AddImage(i, kImage);
  }
  const auto ready = queue.Next();
  ASSERT_TRUE(ready);
  EXPECT_EQ(ready->pose.frame_id, 1999);
  EXPECT_FALSE(queue.Next());
  EXPECT_EQ(queue.lacking().size(), 1999u);
}

TEST(OverlayQueue, ImagesAreBoundedByTheirBytes) {
  OverlayQueue queue(1);
  const cv::Mat large(4000, 4000, CV_8UC1, cv::Scalar(0));
  for (int i = 0; i < 8; ++i) {
    queue.AddImage(i, large);
    queue.AddFeatures(i, {});
  }
  for (int i = 0; i < 8; ++i) queue.AddPose(PoseOf(i));
  int n = 0;
  for (; const auto ready = queue.Next(); ++n) EXPECT_GE(ready->pose.frame_id, 4);
  EXPECT_EQ(n, 4);
}

TEST(OverlayQueue, RightImagesAreKeptAndCounted) {
  OverlayQueue queue(1);
  const cv::Mat left(4000, 2000, CV_8UC1, cv::Scalar(0)), right(4000, 2000, CV_8UC1, cv::Scalar(7));
  for (int i = 0; i < 8; ++i) {
    queue.AddImage(i, left, right);
    queue.AddFeatures(i, {});
    queue.AddPose(PoseOf(i));
  }
  int n = 0;
  for (; const auto ready = queue.Next(); ++n) EXPECT_EQ(ready->right.at<uchar>(0, 0), 7);
  EXPECT_EQ(n, 4);
}

TEST(OverlayQueue, EmptyImageIsIgnored) {
  OverlayQueue queue(1);
  queue.AddPose(PoseOf(0));
  queue.AddFeatures(0, {});
  queue.AddImage(0, {});
  EXPECT_FALSE(queue.Next());
}

}  // namespace
}  // namespace plslam::viewer
