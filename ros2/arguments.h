// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "ros2/options.h"

namespace CLI {
class App;
}

namespace plslam::ros2 {

/// The command line, which overrides the configuration.
struct Arguments {
  std::optional<std::string> left, right, camera, space, map_file;
  std::optional<PublishedTf> publish_tf;
  std::vector<std::string> frames;  ///< "base=base_link"
  std::vector<std::string> remaps;  ///< "left:=/a/left"

  void AddTo(CLI::App* app);
  /// Throws std::runtime_error that names the option whose value cannot be used, or is missing.
  void Apply(Ros2Options* options) const;
};

/// Returns the arguments with those that launch files of ROS pass, from --ros-args to -- or to the end, in our words:
/// "-r from:=to" becomes "--remap from:=to". Parameters (use_sim_time) and log levels are for nodes of ROS, and dropped:
/// images have their own times.
std::vector<std::string> WithoutRosArguments(const std::vector<std::string>& arguments);

}  // namespace plslam::ros2
