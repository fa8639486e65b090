// SPDX-License-Identifier: BSD-3-Clause
#include "viewer_headless/overlay.h"

#include <gmock/gmock.h>

namespace plslam::viewer {
namespace {

const cv::Mat kImage(4, 4, CV_8UC1, cv::Scalar(0));

FramePose PoseOf(int64_t frame_id) {
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

TEST(OverlayQueue, OldIncompleteFramesAreDroppedAndLacking) {
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

TEST(OverlayQueue, RightImagesComeAlongAndCount) {
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

TEST(OverlayQueue, EmptyImageIsNoPart) {
  OverlayQueue queue(1);
  queue.AddPose(PoseOf(0));
  queue.AddFeatures(0, {});
  queue.AddImage(0, {});
  EXPECT_FALSE(queue.Next());
}

}  // namespace
}  // namespace plslam::viewer
