// SPDX-License-Identifier: BSD-3-Clause
#include "ros2/diagnosis.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/datasets/recordings/topic_names.h"
#include "ros2/topic_list.h"

namespace plslam::ros2 {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::Pair;

constexpr const char* kImage = "sensor_msgs/msg/Image";
constexpr const char* kInfo = "sensor_msgs/msg/CameraInfo";

/// A robot that is well, and that a test makes ill.
Symptoms Well() {
  Symptoms s;
  s.left = {"/left/image_raw", kImage, {1, "", 50}, 1'000'000'000, 950'000'000};
  s.right = {"/right/image_raw", kImage, {1, "", 50}, 1'020'000'000, 970'000'000};
  s.infos = {{"/left/camera_info", kInfo, {1, "", 50}, {}, {}}, {"/right/camera_info", kInfo, {1, "", 50}, {}, {}}};
  s.publishers = {
      {"/left/image_raw", kImage}, {"/right/image_raw", kImage}, {"/left/camera_info", kInfo}, {"/tf", "x"}};
  s.max_skew_ms = 5.0;
  return s;
}

TEST(Ros2Diagnosis, EveryCauseHasItsSentence) {
  Symptoms s = Well();
  EXPECT_THAT(WhyNoFrames(s), HasSubstr("within 5 ms (ros2.max_skew_ms): the cameras are not synchronised"));
  s.right.stamp_ns = *s.right.stamp_ns + 3'600'000'000'000;
  EXPECT_THAT(WhyNoFrames(s), HasSubstr("are 3600.020 s apart: they are of two clocks"));
  s.left.previous_stamp_ns = s.left.stamp_ns;
  EXPECT_THAT(WhyNoFrames(s), HasSubstr("the stamps of /left/image_raw are all 1 s: its driver must set them"));
  s.n_rejected = 3;
  EXPECT_THAT(WhyNoFrames(s), HasSubstr("its driver must set them")) << "equal stamps on both sides are rejected";
  s.left.previous_stamp_ns.reset();
  s.right.stamp_ns = s.left.stamp_ns;
  EXPECT_EQ(WhyNoFrames(s), "no image could be used: see the log");
  s.infos[1].state.n_messages = 0;
  EXPECT_THAT(WhyNoFrames(s), HasSubstr("images arrive without CameraInfo: no topic /right/camera_info in the domain "
                                        "0; topics of its type are /left/camera_info"));
  s.has_rig = true;
  EXPECT_EQ(WhyNoFrames(s), "no image could be used: see the log");
  s.right.state.n_messages = 0;
  EXPECT_THAT(WhyNoFrames(s), HasSubstr("/left/image_raw arrives without right images: /right/image_raw has a "
                                        "publisher, but nothing arrives"));
  s.right.state = {0, "reliability", 0};
  EXPECT_THAT(WhyNoFrames(s), HasSubstr("has an incompatible quality of service (reliability)"));
  s.publishers[1].type = "sensor_msgs/msg/PointCloud2";
  EXPECT_THAT(WhyNoFrames(s),
              HasSubstr("/right/image_raw has the type sensor_msgs/msg/PointCloud2, not " + std::string(kImage)));
  s.right.topic = "/rihgt/image_raw";
  s.publishers[1].type = kImage;
  EXPECT_THAT(WhyNoFrames(s), HasSubstr("the nearest name is /right/image_raw"));
  s.publishers.clear();
  s.domain = 7;
  EXPECT_THAT(WhyNoFrames(s), HasSubstr("no publisher of ROS 2 was found in the domain 7"));
}

TEST(Ros2Diagnosis, StereoCamerasAreFoundByTheirNames) {
  const std::vector<Publisher> publishers{{"/camera/infra1/image_rect_raw", kImage},
                                          {"/camera/infra2/image_rect_raw", kImage},
                                          {"/zed/left/image", kImage},
                                          {"/zed/right/image", kImage},
                                          {"/left/alone", kImage},
                                          {"/right/alone", "x"}};
  EXPECT_THAT(StereoTopics(ImageTopics(publishers)),
              ElementsAre(Pair("/camera/infra1/image_rect_raw", "/camera/infra2/image_rect_raw"),
                          Pair("/zed/left/image", "/zed/right/image")));
}

TEST(Ros2Diagnosis, TableOfTopics) {
  const std::string table =
      TopicTable({{"/left/image_raw", kImage, true, false}, {"/right/image_raw", kImage, false, false}},
                 {{"/left/image_raw", {40, 40 * 360'960, "mono8", 752, 480}}, {"/right/image_raw", {}}}, 2.0, 3);
  EXPECT_THAT(table, HasSubstr("2 topics in the domain 3"));
  EXPECT_THAT(table, HasSubstr("1 publisher, reliable, volatile, 20.0 Hz, 7.2 MB/s, 752 x 480 mono8"));
  EXPECT_THAT(table, HasSubstr("best effort, volatile, nothing heard"));
  EXPECT_THAT(table, HasSubstr("Stereo cameras:\n  plslam run ros2:/left/image_raw,/right/image_raw\n"));
  const std::string rgbd = TopicTable({{"/camera/color/image_raw", kImage, true, false},
                                       {"/camera/aligned_depth_to_color/image_raw", kImage, true, false},
                                       {"/arm/imu", "sensor_msgs/msg/Imu", true, false},
                                       {"/camera/accel/sample", "sensor_msgs/msg/Imu", true, false},
                                       {"/camera/gyro/sample", "sensor_msgs/msg/Imu", true, false}},
                                      {}, 2.0, 0);
  EXPECT_THAT(rgbd, HasSubstr("RGB-D cameras:\n  plslam run "
                              "ros2:/camera/color/image_raw,/camera/aligned_depth_to_color/image_raw --set "
                              "ros2.imu=/camera/gyro/sample\n"));
}

}  // namespace
}  // namespace plslam::ros2
