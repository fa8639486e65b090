// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace plslam::launcher {

/// A robot of ROS 2 as a dataset: "ros2:/stereo/left/image_raw,/stereo/right/image_raw".
inline constexpr std::string_view kRos2Prefix = "ros2:";

/// Options of `plslam run`.
struct RunOptions {
  std::string dataset;
  /// `dataset` is a rig file: frames come from live cameras, or a substitute for them.
  bool from_cameras = false;
  /// `dataset` is "ros2:LEFT,RIGHT": frames come from a robot.
  bool from_ros2 = false;
  std::string kind;
  std::vector<std::string> topics;  ///< left and right, of a recording; empty: found by their names
  std::filesystem::path out;
  std::string pace;
  std::string features;
  bool no_mapping = false;
  bool no_loops = false;
  bool dense = false;
  /// A saved map to continue, and whether it remains unchanged; and the file in which to save the map at the end.
  /// Empty: none.
  std::filesystem::path map;
  bool localise_only = false;
  std::filesystem::path save_map;
  /// The part of the camera that the adjustment of the whole map after the run estimates; empty: no adjustment.
  std::string refine;
  std::string config_file;
  std::vector<std::string> overrides;
  int64_t start = -1;  ///< -1: not given, as with the next three
  int64_t stop = -1;
  int64_t stride = -1;
  int64_t loop = -1;
  bool bounce = false;
  bool skip_bad = false;
  int64_t overlay_every = -1;
  /// Port of the live page, -1: none; and the film of the run, empty: none.
  int64_t serve = -1;
  std::filesystem::path video;
  std::string url;
  /// Whether the URL is private to this run.
  bool own_bus = false;
  std::string prefix;
  std::string map_prefix;
  /// Event log of all traffic; empty: none.
  std::filesystem::path record;
  bool quiet = false;
  bool verbose = false;
  bool strict = false;
  /// Whether an existing recording or map is replaced.
  bool force = false;
  bool json = false;
  int max_restarts = 5;
};

}  // namespace plslam::launcher
