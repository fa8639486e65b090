// SPDX-License-Identifier: BSD-3-Clause
#include "adapter/command_line.h"

#include <CLI/CLI.hpp>
#include <stdexcept>

namespace plslam::adapter {

void AdapterCommandLine::AddTo(void* app) {
  auto& cli = *static_cast<CLI::App*>(app);
  cli.add_option("--foreign-url", foreign_url_, "LCM URL of the robot (LCM_DEFAULT_URL, or LCM's default)");
  cli.add_option("--camera", camera_, "rig file (without one: sensor_msgs.CameraInfo of the robot)");
  cli.add_option("--images", images_, "channel of bot_core.images_t, left and right image in one");
  cli.add_option("--left", left_, "channel of left images, sensor_msgs.Image or sensor_msgs.CompressedImage");
  cli.add_option("--right", right_, "channel of right images");
}

AdapterOptions AdapterCommandLine::Options(const Config& config) const {
  AdapterOptions options;
  config.Read("adapter", options);
  if (foreign_url_) options.foreign_url = *foreign_url_;
  if (camera_) options.camera = *camera_;
  if (images_) options.images = *images_;
  if (left_) options.left = *left_;
  if (right_) options.right = *right_;
  const bool in_one = !options.images.empty(), left = !options.left.empty(), right = !options.right.empty();
  if (in_one == (left || right) || left != right) {
    throw std::runtime_error("give the channel of the images: --images CHANNEL, or --left CHANNEL --right CHANNEL");
  }
  if (in_one && options.camera.empty()) {
    throw std::runtime_error("bot_core.images_t has no calibration: give a file with --camera");
  }
  if (!options.robot_odometry.empty() && options.robot_odometry == options.odometry) {
    throw std::runtime_error("adapter.robot_odometry is the channel on which adapter.odometry is published: " +
                             options.odometry);
  }
  return options;
}

}  // namespace plslam::adapter
