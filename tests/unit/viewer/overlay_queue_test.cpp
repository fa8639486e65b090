#include "viewer_headless/overlay_queue.h"

#include <gtest/gtest.h>

namespace plslam {
namespace {

const cv::Mat kImage(4, 4, CV_8UC1, cv::Scalar(0));

TEST(OverlayQueue, PartsInAnyOrderMakeAPicture) {
  OverlayQueue queue(5);
  EXPECT_FALSE(queue.AddCaption(10, "caption"));
  EXPECT_FALSE(queue.AddImage(10, kImage));
  const auto ready = queue.AddFeatures(10, {{{{1, 1}, 2.0F, 3}}, {}});
  ASSERT_TRUE(ready);
  EXPECT_EQ(ready->frame_id, 10);
  EXPECT_EQ(ready->caption, "caption");
  EXPECT_EQ(ready->features.points.size(), 1u);
  EXPECT_FALSE(queue.AddImage(10, kImage)) << "each picture once";
}

TEST(OverlayQueue, OnlyEveryNthFrameIsWanted) {
  EXPECT_TRUE(OverlayQueue(5).Wants(0));
  EXPECT_FALSE(OverlayQueue(5).Wants(4));
  EXPECT_FALSE(OverlayQueue(5).Wants(-5));
  EXPECT_FALSE(OverlayQueue(0).Wants(0));
  OverlayQueue queue(5);
  EXPECT_FALSE(queue.AddCaption(4, "x"));
  EXPECT_FALSE(queue.AddFeatures(4, {}));
  EXPECT_FALSE(queue.AddImage(4, kImage));
}

TEST(OverlayQueue, OldIncompleteFramesAreDropped) {
  OverlayQueue queue(1);
  for (int i = 0; i < 100; ++i) queue.AddCaption(i, "x");
  queue.AddFeatures(0, {});
  EXPECT_FALSE(queue.AddImage(0, kImage));
  queue.AddFeatures(99, {});
  EXPECT_TRUE(queue.AddImage(99, kImage));
}

TEST(OverlayQueue, EmptyImageIsNoPart) {
  OverlayQueue queue(1);
  queue.AddCaption(0, "x");
  queue.AddFeatures(0, {});
  EXPECT_FALSE(queue.AddImage(0, {}));
}

}  // namespace
}  // namespace plslam
