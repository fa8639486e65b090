// SPDX-License-Identifier: BSD-3-Clause
#include "ros2/arguments.h"

#include <CLI/CLI.hpp>
#include <filesystem>
#include <stdexcept>
#include <utility>

#include <fmt/format.h>

#include "core/errors/error_text.h"
#include "core/errors/log.h"
#include "core/process/choice_argument.h"
#include "ros2/names.h"

namespace plslam::ros2 {
namespace {

/// Applies "-r left:=/a" and "-r __ns:=/robot". Launch files of whole robots pass others, such as /tf:=tf, to all nodes.
void Remap(const std::string& rule, Ros2Options* options) {
  const size_t sign = rule.find(":=");
  if (sign == std::string::npos) {
    throw std::runtime_error(fmt::format("--remap {}: has no := between two names", Shown(rule)));
  }
  const std::string from = rule.substr(0, sign), to = rule.substr(sign + 2);
  if (from == "__ns") {
    options->output_namespace = to;
  } else if (from == "left" || from == "/left") {
    options->left = to;
  } else if (from == "right" || from == "/right") {
    options->right = to;
  } else {
    LogInfo("--remap {}: is ignored (the names here are left, right and __ns)", Shown(rule));
  }
}

}  // namespace

void Arguments::AddTo(CLI::App* app) {
  app->add_option("--left", left, "topic of left images (sensor_msgs/Image, or CompressedImage: .../compressed)");
  app->add_option("--right", right, "topic of right images");
  app->add_option("--camera", camera, "rig file (without one: CameraInfo beside the images)");
  AddChoice(app, "--publish-tf", publish_tf, "map to odom and odom to the body: all, map, odom or none");
  app->add_option("--namespace", space, "in front of the topics that are published (/plslam)");
  app->add_option("--frame", frames, "name of a frame: map=NAME, odom=NAME, base=NAME or camera=NAME (repeatable)")
      ->type_name("FRAME=NAME")
      ->allow_extra_args(false);
  app->add_option("--map-file", map_file, "map file of the services save and load");
  app->add_flag_callback(
      "--topics", [] {}, "list the topics of the domain for four seconds, and exit");
  app->add_option("--remap", remaps, "other name: left:=TOPIC, right:=TOPIC or __ns:=NAMESPACE, as in --ros-args -r")
      ->type_name("FROM:=TO")
      ->allow_extra_args(false);
}

void Arguments::Apply(Ros2Options* options) const {
  for (const std::string& rule : remaps) Remap(rule, options);
  if (left) options->left = *left;
  if (right) options->right = *right;
  if (camera) options->camera = *camera;
  if (publish_tf) options->publish_tf = *publish_tf;
  if (space) options->output_namespace = *space;
  if (map_file) options->map_file = *map_file;
  if (!options->map_file.empty()) options->map_file = std::filesystem::absolute(options->map_file).string();
  for (const std::string& frame : frames) {
    const size_t sign = frame.find('=');
    const std::string name = frame.substr(0, sign);
    std::string* const known = name == "map"      ? &options->map_frame
                               : name == "odom"   ? &options->odom_frame
                               : name == "base"   ? &options->base_frame
                               : name == "camera" ? &options->camera_frame
                                                  : nullptr;
    if (known == nullptr || sign == std::string::npos || sign + 1 == frame.size()) {
      throw std::runtime_error(
          fmt::format("--frame {}: is not map=NAME, odom=NAME, base=NAME or camera=NAME", Shown(frame)));
    }
    *known = frame.substr(sign + 1);
  }
  if (!options->imu.empty()) {
    const std::string complaint = TopicNameComplaint(options->imu);
    if (!complaint.empty())
      throw std::runtime_error(fmt::format("ros2.imu = {}: {}", Shown(options->imu), complaint));
  }
  for (const auto& [option, topic] : {std::pair("--left", options->left), std::pair("--right", options->right)}) {
    if (topic.empty()) {
      throw std::runtime_error(
          fmt::format("{} is missing: give the topics of the images, --left /stereo/left/image_raw --right "
                      "/stereo/right/image_raw",
                      option));
    }
    const std::string complaint = TopicNameComplaint(topic);
    if (!complaint.empty()) throw std::runtime_error(fmt::format("{} {}: {}", option, Shown(topic), complaint));
  }
}

std::vector<std::string> WithoutRosArguments(const std::vector<std::string>& arguments) {
  std::vector<std::string> ours;
  bool is_of_ros = false;
  for (size_t i = 0; i < arguments.size(); ++i) {
    const std::string& argument = arguments[i];
    if (argument == "--ros-args" || (is_of_ros && argument == "--")) {
      is_of_ros = argument != "--";
    } else if (!is_of_ros) {
      ours.push_back(argument);
    } else if ((argument == "-r" || argument == "--remap") && i + 1 < arguments.size()) {
      ours.insert(ours.end(), {"--remap", arguments[++i]});
    }
  }
  return ours;
}

}  // namespace plslam::ros2
