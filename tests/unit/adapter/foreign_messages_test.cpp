// SPDX-License-Identifier: BSD-3-Clause
#include "adapter/node/foreign_messages.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <map>
#include <set>

#include "adapter/node/foreign_layouts.h"
#include "bot_core/images_t.hpp"
#include "bot_core/ins_t.hpp"
#include "core/bus/transport/stock_lcm.h"
#include "core/files/dataset_error.h"
#include "core/ros/body_messages.h"
#include "geometry_msgs/Vector3.hpp"
#include "microstrain/ins_t.hpp"
#include "nav_msgs/Odometry.hpp"
#include "sensor_msgs/CameraInfo.hpp"
#include "sensor_msgs/CompressedImage.hpp"
#include "sensor_msgs/Image.hpp"
#include "sensor_msgs/Imu.hpp"

namespace plslam::adapter {
namespace {

using bus::Encoded;
using testing::ElementsAre;
using testing::HasSubstr;

// Fingerprints from the public definitions: a wrong name, type or order of a member changes them. The fingerprint of
// bot_core.images_t and of both ins_t are computed by our own code.
TEST(ForeignTypes, HaveTheFingerprintsOfOtherPrograms) {
  const std::map<std::string, uint64_t> known = {
      {"bot_core.pose_t", 0x2e16efb052b0105e},
      {"bot_core.image_metadata_t", 0x9a4b634d0577fb8e},
      {"bot_core.image_t", 0x14739ffe13d5f5f0},
      {"bot_core.images_t", 0x20ba4f05e8f5e33a},
      {"std_msgs.Time", 0xbc3a494751d96c91},
      {"std_msgs.Header", 0x2fdb11453be64af7},
      {"geometry_msgs.Vector3", 0xae7e5fba5eeca11e},
      {"geometry_msgs.Point", 0xae7e5fba5eeca11e},
      {"geometry_msgs.Quaternion", 0x363bdd3bf9180a2b},
      {"geometry_msgs.Pose", 0x245634ae2ab17b76},
      {"geometry_msgs.PoseWithCovariance", 0xce6428b127d11b5a},
      {"geometry_msgs.Twist", 0x2e7c07d7cdf7e027},
      {"geometry_msgs.TwistWithCovariance", 0xb439635a59217509},
      {"geometry_msgs.Transform", 0xee5ff42647bf3f91},
      {"geometry_msgs.TransformStamped", 0x299ff424b83a3514},
      {"nav_msgs.Odometry", 0x94e17f94648cf0e4},
      {"sensor_msgs.Image", 0x535cface1f4f5717},
      {"sensor_msgs.CompressedImage", 0xb8d011c10412b9a1},
      {"sensor_msgs.RegionOfInterest", 0x73150d3a0b307e1c},
      {"sensor_msgs.CameraInfo", 0xafb501b00707a02a},
      {"sensor_msgs.PointField", 0xe05c1c07e0850bae},
      {"sensor_msgs.PointCloud2", 0xf5eb3da1c2853175},
      {"tf2_msgs.TFMessage", 0xc2b8a1c33a8923ec},
      {"sensor_msgs.Imu", 0x31ab205c8dd57aa8},
      {"bot_core.ins_t", 0x88a7df61422b0840},
      {"microstrain.ins_t", 0xc4ed03e76b12d79a},
  };
  std::set<std::string> seen;
  for (const MessageLayout& layout : ForeignLayouts()) {
    const std::string name(layout.name);
    seen.insert(name);
    ASSERT_TRUE(known.contains(name)) << name;
    EXPECT_EQ(static_cast<uint64_t>(layout.fingerprint()), known.at(name)) << name;
  }
  EXPECT_EQ(seen.size(), known.size());
}

bot_core::image_t BotImage(int value) {
  bot_core::image_t image{};
  image.width = 4;
  image.height = 2;
  image.row_stride = 4;
  image.pixelformat = 1497715271;
  image.data.assign(8, static_cast<uint8_t>(value));
  image.size = 8;
  return image;
}

bot_core::images_t BotPair() {
  bot_core::images_t pair{};
  pair.utime = 1'764'000'000'123'456;
  pair.image_types = {4, 1, 0};
  pair.images = {BotImage(4), BotImage(1), BotImage(0)};
  pair.n_images = 3;
  return pair;
}

template <class F>
std::string ErrorOf(const F& f) {
  try {
    f();
  } catch (const DatasetError& error) {
    return error.what();
  }
  return "";
}

TEST(ForeignMessages, LeftAndRightOfABotPairAmongOthers) {
  const auto [left, right] = PairFromBytes(Encoded(BotPair()));
  EXPECT_EQ(left.t_ns, 1'764'000'000'123'456'000);
  EXPECT_EQ(left.bytes, std::vector<uint8_t>(8, 0));
  EXPECT_EQ(right.bytes, std::vector<uint8_t>(8, 1));
  EXPECT_EQ(left.encoding, "mono8");
}

TEST(ForeignMessages, InvalidBotPairsAreNamed) {
  bot_core::images_t pair = BotPair();
  pair.image_types[2] = 7;
  EXPECT_THAT(ErrorOf([&] { PairFromBytes(Encoded(pair)); }), HasSubstr("has no left image"));
  pair = BotPair();
  pair.utime = -1;
  EXPECT_THAT(ErrorOf([&] { PairFromBytes(Encoded(pair)); }), HasSubstr("utime"));
  std::vector<uint8_t> bytes = Encoded(BotPair());
  bytes.pop_back();
  EXPECT_THAT(ErrorOf([&] { PairFromBytes(bytes); }), HasSubstr("truncated or damaged"));
  EXPECT_THAT(ErrorOf([&] { PairFromBytes(Encoded(geometry_msgs::Vector3{})); }), HasSubstr("is not a bot_core"));
  EXPECT_THAT(ErrorOf([&] { PairFromBytes({}); }), HasSubstr("is not a bot_core.images_t"));
}

nav_msgs::Odometry Wheels() {
  nav_msgs::Odometry message{};
  message.header.stamp.sec = 7;
  message.header.stamp.nsec = 5;
  message.pose.pose.position.x = 3.0;
  message.pose.pose.orientation.z = message.pose.pose.orientation.w = std::sqrt(0.5);
  return message;
}

TEST(ForeignMessages, OdometryOfARobotIsAPoseOfItsBody) {
  const RobotPose pose = RobotPoseFromBytes(Encoded(Wheels()));
  EXPECT_EQ(pose.t_ns, 7'000'000'005);
  const Eigen::Vector3d ahead = pose.T_robot_b * Eigen::Vector3d::UnitX();
  EXPECT_LT((ahead - Eigen::Vector3d(3.0, 1.0, 0.0)).norm(), 1e-12);
}

TEST(ForeignMessages, InvalidOdometryIsNamed) {
  nav_msgs::Odometry bad = Wheels();
  bad.pose.pose.orientation = {};
  EXPECT_THAT(ErrorOf([&] { RobotPoseFromBytes(Encoded(bad)); }), HasSubstr("has an invalid pose"));
  bad = Wheels();
  bad.pose.pose.position.y = std::nan("");
  EXPECT_THAT(ErrorOf([&] { RobotPoseFromBytes(Encoded(bad)); }), HasSubstr("has an invalid pose"));
  bad = Wheels();
  bad.header.stamp.sec = -1;
  EXPECT_THAT(ErrorOf([&] { RobotPoseFromBytes(Encoded(bad)); }), HasSubstr("invalid stamp"));
  EXPECT_THAT(ErrorOf([&] { RobotPoseFromBytes(Encoded(BotPair())); }), HasSubstr("is not a nav_msgs.Odometry"));
}

sensor_msgs::Imu RosImu() {
  sensor_msgs::Imu imu{};
  imu.header.stamp.sec = 12;
  imu.header.stamp.nsec = 34;
  imu.orientation_covariance[0] = -1.0;
  imu.angular_velocity.y = 0.25;
  imu.linear_acceleration.z = 9.75;
  return imu;
}

TEST(ForeignMessages, SamplesOfEachInertialType) {
  const ImuSample expected{12'000'000'034, {0.0, 0.25, 0.0}, {0.0, 0.0, 9.75}};
  EXPECT_EQ(ImuSampleFromBytes(Encoded(RosImu())), expected);
  bot_core::ins_t bot{};
  bot.utime = 5;
  bot.gyro[0] = 0.5;
  bot.accel[2] = 9.5;
  EXPECT_EQ(ImuSampleFromBytes(Encoded(bot)), (ImuSample{5000, {0.5, 0.0, 0.0}, {0.0, 0.0, 9.5}}));
  microstrain::ins_t microstrain{};
  microstrain.utime = 6;
  microstrain.gyro[1] = 0.5;
  microstrain.accel[0] = 1.5;
  EXPECT_EQ(ImuSampleFromBytes(Encoded(microstrain)), (ImuSample{6000, {0.0, 0.5, 0.0}, {1.5, 0.0, 0.0}}));

  sensor_msgs::Imu bad = RosImu();
  bad.linear_acceleration_covariance[0] = -1.0;
  EXPECT_THAT(ErrorOf([&] { ImuSampleFromBytes(Encoded(bad)); }), HasSubstr("nothing was measured"));
  bad = RosImu();
  bad.angular_velocity.x = std::nan("");
  EXPECT_THAT(ErrorOf([&] { ImuSampleFromBytes(Encoded(bad)); }), HasSubstr("not finite"));
  bot.utime = -1;
  EXPECT_THAT(ErrorOf([&] { ImuSampleFromBytes(Encoded(bot)); }), HasSubstr("invalid utime"));
  EXPECT_THAT(ErrorOf([&] { ImuSampleFromBytes(Encoded(BotPair())); }),
              HasSubstr("is none of sensor_msgs.Imu, bot_core.ins_t and microstrain.ins_t"));
}

sensor_msgs::Image RosImage() {
  sensor_msgs::Image image{};
  image.header.stamp.sec = 12;
  image.header.stamp.nsec = 34;
  image.height = 2;
  image.width = 4;
  image.step = 4;
  image.encoding = "mono8";
  image.data.assign(8, 5);
  image.data_length = 8;
  return image;
}

TEST(ForeignMessages, RosImagesByTheirFingerprint) {
  const robot::ForeignImage image = ImageFromBytes(Encoded(RosImage()));
  EXPECT_EQ(image.t_ns, 12'000'000'034);
  EXPECT_EQ(image.encoding, "mono8");
  EXPECT_EQ(image.step_bytes, 4);
  sensor_msgs::CompressedImage compressed{};
  compressed.format = "jpeg";
  compressed.data = {1, 2, 3};
  compressed.data_length = 3;
  EXPECT_EQ(ImageFromBytes(Encoded(compressed)).bytes, compressed.data);
  EXPECT_EQ(ImageFromBytes(Encoded(compressed)).encoding, "");
  sensor_msgs::Image bad = RosImage();
  bad.header.stamp.nsec = 1'000'000'000;
  EXPECT_THAT(ErrorOf([&] { ImageFromBytes(Encoded(bad)); }), HasSubstr("invalid stamp"));
  bad = RosImage();
  bad.encoding = "";
  EXPECT_THAT(ErrorOf([&] { ImageFromBytes(Encoded(bad)); }), HasSubstr("no encoding"));
}

TEST(ForeignMessages, CameraInfosMakeARig) {
  sensor_msgs::CameraInfo info{};
  info.width = 376;
  info.height = 240;
  info.distortion_model = "plumb_bob";
  info.D = {0.1, -0.01, 0.0, 0.0, 0.0};
  info.D_length = 5;
  const double K[9] = {200, 0, 187, 0, 201, 119, 0, 0, 1}, R[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};
  double P[12] = {200, 0, 187, 0, 0, 200, 119, 0, 0, 0, 1, 0};
  std::memcpy(info.K, K, sizeof K);
  std::memcpy(info.R, R, sizeof R);
  std::memcpy(info.P, P, sizeof P);
  const RosCameraInfo left = CameraInfoFromBytes(Encoded(info));
  info.P[3] = -200 * 0.12;
  const RigCalibration rig = RigFromRos(left, CameraInfoFromBytes(Encoded(info)), false);
  EXPECT_NEAR(rig.baseline_m, 0.12, 1e-12);
  EXPECT_EQ(rig.left.model, "radtan");
  EXPECT_EQ(rig.left.fy_px, 201);
  EXPECT_EQ(rig.right.width_px, 376);
}

robot::BodyPose TurnedBody() {
  robot::BodyPose body;
  body.t_ns = 12'000'000'345'000;
  body.T_map_odom = SE3(Eigen::Quaterniond(Eigen::AngleAxisd(0.5, Eigen::Vector3d::UnitZ())), {1, 2, 3});
  body.T_odom_b = SE3(Eigen::Quaterniond(Eigen::AngleAxisd(0.25, Eigen::Vector3d::UnitX())), {4, 5, 6});
  body.T_map_b = body.T_map_odom * body.T_odom_b;
  for (int i = 0; i < 36; ++i) body.covariance(i / 6, i % 6) = i;
  body.velocity = Vector6d::Zero();
  *body.velocity << 1, 2, 3, 4, 5, 6;
  body.velocity_covariance = 2.0 * body.covariance;
  return body;
}

TEST(ForeignMessages, BotPoseIsTheBodyInTheMap) {
  const robot::BodyPose body = TurnedBody();
  const bot_core::pose_t pose = ToBotPose(body);
  EXPECT_EQ(pose.utime, 12'000'000'345);
  EXPECT_THAT(pose.vel, ElementsAre(1, 2, 3));
  EXPECT_THAT(pose.rotation_rate, ElementsAre(4, 5, 6));
  EXPECT_EQ(pose.pos[1], body.T_map_b.translation().y());
  EXPECT_EQ(pose.orientation[0], body.T_map_b.rotation().w());
  EXPECT_EQ(pose.orientation[3], body.T_map_b.rotation().z());
}

TEST(ForeignMessages, OdometryIsTheBodyInOdom) {
  robot::BodyPose body = TurnedBody();
  const RobotFrames frames;
  nav_msgs::Odometry odometry = ToOdometry(BodyOdometry(body, frames));
  EXPECT_EQ(odometry.header.frame_id, "odom");
  EXPECT_EQ(odometry.child_frame_id, "base_link");
  EXPECT_EQ(odometry.header.stamp.sec, 12'000);
  EXPECT_EQ(odometry.header.stamp.nsec, 345'000);
  EXPECT_EQ(odometry.pose.pose.position.z, 6.0);
  EXPECT_EQ(odometry.pose.covariance[1 * 6 + 3], 9.0) << "row major";
  EXPECT_EQ(odometry.twist.covariance[35], 70.0);
  EXPECT_EQ(odometry.twist.twist.angular.z, 6.0);
  body.velocity.reset();
  odometry = ToOdometry(BodyOdometry(body, frames));
  EXPECT_EQ(odometry.twist.twist.linear.x, 0.0);
  EXPECT_EQ(odometry.twist.covariance[0], 1e6);
}

TEST(ForeignMessages, TransformsGoFromMapOverOdomToTheBody) {
  const RobotFrames frames;
  const tf2_msgs::TFMessage message = ToTransforms(12, BodyTransforms(TurnedBody(), frames));
  ASSERT_EQ(message.transforms_length, 2);
  EXPECT_EQ(message.transforms[0].header.frame_id + ">" + message.transforms[0].child_frame_id, "map>odom");
  EXPECT_EQ(message.transforms[1].header.frame_id + ">" + message.transforms[1].child_frame_id, "odom>base_link");
  EXPECT_EQ(message.transforms[0].transform.translation.y, 2.0);
  EXPECT_NEAR(message.transforms[0].transform.rotation.z, std::sin(0.25), 1e-12);
}

TEST(ForeignMessages, PointCloudHasThePointsOfTheMap) {
  Map map;
  for (int i = 0; i < 3; ++i) {
    MapPoint point;
    point.id = i;
    point.p_w = {1.0 * i, 2.0, 3.0};
    map.Put(point);
  }
  const SE3 T_b_c(Eigen::Quaterniond::Identity(), {10.0, 0.0, 0.0});
  const sensor_msgs::PointCloud2 cloud = ToPointCloud(T_b_c, map, 5);
  EXPECT_EQ(cloud.header.frame_id, "map");
  EXPECT_EQ(cloud.width * cloud.height, 3);
  ASSERT_EQ(cloud.data.size(), 36U);
  EXPECT_EQ(cloud.data_length, 36);
  EXPECT_EQ(cloud.row_step, 36);
  ASSERT_EQ(cloud.fields_length, 3);
  EXPECT_EQ(cloud.fields[2].name + std::to_string(cloud.fields[2].offset), "z8");
  float last[3];
  std::memcpy(last, &cloud.data[24], sizeof last);
  EXPECT_THAT(last, ElementsAre(12.0F, 2.0F, 3.0F));
}

}  // namespace
}  // namespace plslam::adapter
