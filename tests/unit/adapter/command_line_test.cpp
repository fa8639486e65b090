// SPDX-License-Identifier: BSD-3-Clause
#include "adapter/command_line.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <CLI/CLI.hpp>

#include "adapter/node/image_source.h"

namespace plslam::adapter {
namespace {

AdapterOptions Parse(const std::vector<std::string>& arguments, const Config& config = {}) {
  CLI::App app;
  AdapterCommandLine command_line;
  command_line.AddTo(&app);
  std::vector<const char*> argv = {"adapter"};
  for (const std::string& argument : arguments) argv.push_back(argument.c_str());
  app.parse(static_cast<int>(argv.size()), argv.data());
  return command_line.Options(config);
}

TEST(AdapterCommandLine, NamesImagesOfOneKind) {
  const AdapterOptions options = Parse({"--left", "/l", "--right", "/r", "--foreign-url", "udpm://"});
  EXPECT_EQ(options.left + options.right + options.foreign_url, "/l/rudpm://");
  EXPECT_THROW(Parse({}), std::runtime_error);
  EXPECT_THROW(Parse({"--left", "/l"}), std::runtime_error);
  EXPECT_THROW(Parse({"--images", "CAMERA", "--right", "/r", "--camera", "a.yaml"}), std::runtime_error);
  EXPECT_THROW(Parse({"--images", "CAMERA"}), std::runtime_error) << "images_t has no calibration";
  EXPECT_EQ(Parse({"--images", "CAMERA", "--camera", "a.yaml"}).camera, "a.yaml");
}

TEST(AdapterCommandLine, WinsOverTheConfiguration) {
  Config config;
  config.Override("adapter.left=/from_file");
  config.Override("adapter.right=/right");
  EXPECT_EQ(Parse({"--left", "/l"}, config).left, "/l");
  EXPECT_EQ(Parse({}, config).left, "/from_file");
}

TEST(AdapterCommandLine, RejectsItsOwnOdometryAsInput) {
  Config config;
  config.Override("adapter.robot_odometry=/wheels#nav_msgs.Odometry");
  EXPECT_EQ(Parse({"--left", "/l", "--right", "/r"}, config).robot_odometry, "/wheels#nav_msgs.Odometry");
  config.Override("adapter.robot_odometry=/odom#nav_msgs.Odometry");
  EXPECT_THROW(Parse({"--left", "/l", "--right", "/r"}, config), std::runtime_error);
}

TEST(InfoChannel, IsBesideTheImages) {
  EXPECT_EQ(InfoChannelOf("/left#sensor_msgs.Image"), "/left/camera_info#sensor_msgs.CameraInfo");
  EXPECT_EQ(InfoChannelOf("/a/left/image_raw#sensor_msgs.Image"), "/a/left/camera_info#sensor_msgs.CameraInfo");
  EXPECT_EQ(InfoChannelOf("LEFT"), "LEFT/camera_info");
  EXPECT_EQ(InfoChannelOf("/l/image_raw/compressed#sensor_msgs.CompressedImage"),
            "/l/camera_info#sensor_msgs.CameraInfo");
}

}  // namespace
}  // namespace plslam::adapter
