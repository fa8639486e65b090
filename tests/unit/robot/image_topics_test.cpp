// SPDX-License-Identifier: BSD-3-Clause
#include "core/robot/image_topics.h"

#include <gtest/gtest.h>

namespace plslam::robot {
namespace {

TEST(ImageTopics, CameraInfoIsBesideTheImages) {
  EXPECT_EQ(InfoTopicOf("/a/left/image_raw"), "/a/left/camera_info");
  EXPECT_EQ(InfoTopicOf("/a/left/image_raw/compressed"), "/a/left/camera_info");
  EXPECT_EQ(InfoTopicOf("/a/depth/image_raw/compressedDepth"), "/a/depth/camera_info");
  EXPECT_EQ(InfoTopicOf("/left"), "/left/camera_info");
}

TEST(ImageTopics, CompressedOnesAreKnownByTheirEnd) {
  EXPECT_TRUE(IsCompressedTopic("/left/image_raw/compressed"));
  EXPECT_TRUE(IsCompressedTopic("/depth/image_raw/compressedDepth"));
  EXPECT_FALSE(IsCompressedTopic("/compressed/image_raw"));
}

}  // namespace
}  // namespace plslam::robot
