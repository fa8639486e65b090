// SPDX-License-Identifier: BSD-3-Clause
#include "ros2/arguments.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <stdexcept>

namespace plslam::ros2 {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

std::string ErrorOf(const Arguments& arguments) {
  Ros2Options options;
  try {
    arguments.Apply(&options);
  } catch (const std::runtime_error& error) {
    return error.what();
  }
  return "";
}

TEST(Ros2Arguments, LaunchFilesOfRosAreUnderstood) {
  EXPECT_THAT(WithoutRosArguments({"plslam_ros2", "--camera", "c.yaml", "--ros-args", "-r", "left:=/a", "-p",
                                   "use_sim_time:=true", "--log-level", "info", "--", "--frame", "base=body"}),
              ElementsAre("plslam_ros2", "--camera", "c.yaml", "--remap", "left:=/a", "--frame", "base=body"));
  Arguments arguments;
  arguments.remaps = {"left:=/a/left", "right:=/a/right", "__ns:=/robot", "__node:=slam"};
  arguments.frames = {"base=body", "camera=eye"};
  Ros2Options options;
  arguments.Apply(&options);
  EXPECT_EQ(options.left, "/a/left");
  EXPECT_EQ(options.output_namespace, "/robot");
  EXPECT_EQ(options.base_frame, "body");
  EXPECT_EQ(options.camera_frame, "eye");
}

TEST(Ros2Arguments, WrongValuesAreNamed) {
  Arguments arguments;
  EXPECT_THAT(ErrorOf(arguments), HasSubstr("--left is missing: give the topics of the images"));
  arguments.left = "left";
  arguments.right = "/right";
  EXPECT_THAT(ErrorOf(arguments), HasSubstr("--left left: does not begin with /"));
  arguments.left = "/left";
  EXPECT_EQ(ErrorOf(arguments), "");
  arguments.frames = {"body=x"};
  EXPECT_THAT(ErrorOf(arguments), HasSubstr("--frame body=x: is not map=NAME"));
  arguments.frames.clear();
  arguments.remaps = {"/tf:=tf", "__node:=slam"};
  EXPECT_EQ(ErrorOf(arguments), "") << "launch files pass them to all nodes";
  arguments.remaps = {"left"};
  EXPECT_THAT(ErrorOf(arguments), HasSubstr("has no := between two names"));
}

}  // namespace
}  // namespace plslam::ros2
