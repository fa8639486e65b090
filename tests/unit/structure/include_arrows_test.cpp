// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <optional>
#include <regex>

#include "tests/unit/structure/source_tree.h"

namespace plslam {
namespace {

using test::SourceFile;

/// Permitted includes: `folder` itself and paths that start with one of `may_include`. The longest folder that contains
/// a file applies. Ids (core/ids), configuration's field lists and the sentences of errors (core/errors) may be included
/// everywhere.
struct Arrow {
  std::string folder;
  std::vector<std::string> may_include;
};

const std::vector<Arrow> kArrows = {
    {"lcmtypes/", {}},
    {"core/errors/", {}},
    {"core/geometry/", {}},
    {"core/ids/", {}},
    {"core/files/", {"core/geometry/"}},
    {"core/config/", {"core/errors/"}},
    {"core/features/", {"core/geometry/", "core/config/"}},
    {"core/features/image/", {}},
    {"core/features/matching/",
     {"core/geometry/", "core/features/features.h", "core/features/options.h", "core/features/image/"}},
    {"core/features/points/",
     {"core/geometry/", "core/features/features.h", "core/features/options.h", "core/features/image/",
      "core/features/matching/"}},
    {"core/features/lines/",
     {"core/geometry/", "core/features/features.h", "core/features/options.h", "core/features/image/",
      "core/features/matching/"}},
    {"core/places/", {"core/geometry/", "core/features/", "core/config/", "core/files/"}},
    {"core/motion/", {"core/geometry/", "core/config/"}},
    {"core/inertial/", {"core/geometry/"}},
    {"core/map/",
     {"core/geometry/", "core/inertial/", "core/features/", "core/motion/", "core/files/mapped_file.h",
      "core/config/"}},
    {"core/localisation/", {"core/geometry/", "core/features/", "core/motion/", "core/map/", "core/config/"}},
    {"core/optim/solver/", {}},
    {"core/optim/bundle/",
     {"core/optim/solver/", "core/geometry/", "core/inertial/", "core/motion/", "core/map/", "core/config/"}},
    {"core/optim/reference/", {"core/geometry/", "core/optim/bundle/"}},
    {"core/optim/pose_graph/", {"core/optim/solver/", "core/geometry/", "core/map/", "core/config/"}},
    {"core/io/images/", {"core/files/"}},
    {"core/io/maps/", {"core/geometry/", "core/map/", "core/features/features.h", "core/files/"}},
    {"core/io/trajectories/", {"core/geometry/", "core/config/choices.h", "core/files/"}},
    {"core/ros/",
     {"core/geometry/", "core/files/", "core/io/", "core/map/", "core/robot/body_pose.h",
      "core/run/process_names.h"}},
    {"core/robot/", {"core/geometry/", "core/files/", "core/io/", "core/datasets/"}},
    {"core/robot/node/",
     {"core/robot/", "core/geometry/", "core/files/", "core/io/", "core/datasets/", "core/bus/", "core/process/",
      "core/run/"}},
    {"core/ros/node/",
     {"core/ros/", "core/robot/node/", "core/geometry/", "core/files/", "core/io/", "core/map/", "core/bus/",
      "core/process/", "core/run/"}},
    {"core/accuracy/", {"core/geometry/", "core/io/trajectories/"}},
    {"core/bus/",
     {"lcmtypes/", "core/geometry/", "core/inertial/", "core/config/", "core/files/", "core/io/", "core/map/",
      "core/features/features.h"}},
    {"core/run/", {"core/geometry/", "core/files/", "core/io/", "core/map/"}},
    {"core/run/node/", {"core/run/", "core/geometry/", "core/files/", "core/io/", "core/map/", "core/bus/"}},
    {"core/bus/transport/", {"lcmtypes/", "core/config/", "core/bus/options.h"}},
    {"core/process/", {"core/bus/", "core/config/", "core/run/process_names.h", "lcmtypes/"}},
    {"core/datasets/", {"core/geometry/", "core/files/", "core/io/", "core/bus/", "core/config/"}},
    {"core/datasets/recordings/", {"core/geometry/", "core/files/", "core/io/", "core/datasets/"}},
    {"core/datasets/synthetic/",
     {"core/geometry/", "core/files/", "core/io/", "core/config/nearest_key.h", "core/datasets/dataset.h"}},
    {"core/stream/",
     {"core/geometry/", "core/files/", "core/io/", "core/bus/", "core/process/", "core/run/process_names.h",
      "core/run/run_counters.h"}},
    {"adapter/", {"core/", "lcmtypes/message_layout.h"}},
    {"player/", {"core/"}},
    {"camera/", {"core/"}},
    {"vo_process/", {"core/"}},
    {"vo_process/stereo/", {"core/", "vo_process/options.h"}},
    {"vo_process/tracking/", {"core/", "vo_process/options.h", "vo_process/stereo/"}},
    {"vo_process/tracking/landmarks/", {"core/", "vo_process/options.h", "vo_process/stereo/"}},
    {"vo_process/tracking/motion/",
     {"core/", "vo_process/options.h", "vo_process/stereo/", "vo_process/tracking/landmarks/"}},
    {"vo_process/tracking/calibration/",
     {"core/", "vo_process/options.h", "vo_process/stereo/", "vo_process/tracking/landmarks/",
      "vo_process/tracking/motion/"}},
    {"vo_process/tracking/bodies/",
     {"core/", "vo_process/options.h", "vo_process/stereo/", "vo_process/tracking/landmarks/",
      "vo_process/tracking/motion/", "vo_process/tracking/calibration/"}},
    {"mapping_process/", {"core/"}},
    {"mapping_process/insertion/", {"core/", "mapping_process/options.h"}},
    {"mapping_process/corrections/", {"core/", "mapping_process/options.h", "mapping_process/insertion/"}},
    {"loop_process/", {"core/"}},
    {"viewer_headless/", {"core/"}},
    {"dense_process/", {"core/"}},
    {"ros2/", {"core/"}},
    {"tools/command_line/", {"core/errors/", "core/config/command_line_error.h"}},
    {"tools/launch/", {"core/"}},
    {"tools/evaluate/", {"core/", "tools/command_line/"}},
    {"tools/evaluate/compare/",
     {"core/", "tools/command_line/", "tools/evaluate/", "viewer_headless/report/report_page.h"}},
    {"tools/evaluate/drawing/", {"core/"}},
    {"tools/evaluate/places", {"core/", "tools/command_line/", "tools/evaluate/", "tools/train_vocabulary/"}},
    {"tools/train_vocabulary/", {"core/", "tools/command_line/"}},
    {"tools/evaluate/figures", {"core/", "tools/command_line/", "tools/evaluate/", "tools/export/keyframe_images.h"}},
    {"tools/export/", {"core/", "tools/pose_graph/export.h"}},
    {"tools/doctor/", {"core/", "lcmtypes/"}},
    {"tools/bridge/", {"core/"}},
    {"tools/manual/", {}},
    {"tools/plslam/",
     {"core/", "lcmtypes/message_layout.h", "adapter/options.h", "camera/options.h", "player/options.h",
      "vo_process/options.h", "mapping_process/options.h", "loop_process/options.h", "viewer_headless/options.h",
      "dense_process/options.h", "ros2/options.h", "tools/bridge/options.h", "tools/command_line/", "tools/evaluate/",
      "tools/launch/", "viewer_headless/report/report_page.h"}},
    {"tools/surfaces/", {"core/", "tools/command_line/", "dense_process/dense_map.h", "dense_process/products.h"}},
    {"tools/offline/",
     {"core/process/", "tools/command_line/", "tools/export/export_command.h", "tools/doctor/doctor_command.h",
      "tools/rectify_check/rectify_check_command.h", "tools/calibration/calibration_command.h",
      "tools/refine/refine_command.h"}},
    {"tools/calibration/",
     {"core/", "camera/rig_file.h", "tools/command_line/", "tools/launch/", "tools/rectify_check/row_errors.h"}},
    {"tools/refine/",
     {"core/", "mapping_process/insertion/", "mapping_process/options.h", "tools/evaluate/",
      "viewer_headless/report/report_page.h"}},
    {"tools/rectify_check/",
     {"core/", "tools/command_line/", "vo_process/options.h", "vo_process/stereo/", "vo_process/tracking/"}},
    {"tools/pose_graph/", {"core/", "tools/command_line/"}},
    {"tools/odometry_library/", {"core/", "vo_process/options.h", "vo_process/stereo/", "vo_process/tracking/"}},
};

const std::vector<std::string> kProductFolders = {
    "lcmtypes",        "core",         "adapter",         "camera",        "player", "vo_process",
    "mapping_process", "loop_process", "viewer_headless", "dense_process", "ros2",   "tools"};

/// Files that connect algorithms to messages: the folders named `node`, and readers of messages in logs. All others use
/// neither LCM nor its types.
bool KnowsMessages(const std::string& path) {
  static const std::regex kNode(R"(core/(bus|process)/.*|core/datasets/log_dataset\.cpp|.*/node/.*)");
  return std::regex_match(path, kNode);
}

std::optional<std::string> IncludedFile(const std::string& line) {
  static const std::regex kInclude(R"(\s*#\s*include\s*[<"]([^>"]+)[>"].*)");
  std::smatch match;
  if (!std::regex_match(line, match, kInclude)) return std::nullopt;
  return match[1];
}

bool StartsWith(const std::string& text, const std::string& start) { return text.rfind(start, 0) == 0; }

const Arrow* ArrowOf(const std::string& path) {
  const Arrow* best = nullptr;
  for (const Arrow& arrow : kArrows) {
    if (StartsWith(path, arrow.folder) && (best == nullptr || arrow.folder.size() > best->folder.size()))
      best = &arrow;
  }
  return best;
}

bool IsOfTree(const std::string& include) {
  return include == "tests" || StartsWith(include, "tests/") || ArrowOf(include) != nullptr;
}

/// Ours, and those of lcmtypes/foreign/.
bool IsMessage(const std::string& include) {
  static const std::regex kMessage(R"(plslam/\w+_t\.hpp|(bot_core|microstrain)/\w+_t\.hpp|(\w+_msgs)/\w+\.hpp)");
  return std::regex_match(include, kMessage);
}

/// Returns the reason why `file` must not include `include`; empty if it may.
std::string Objection(const std::string& file, const std::string& include) {
  if (StartsWith(include, "lcm/") && !StartsWith(file, "core/bus/")) return "only core/bus knows LCM";
  if (IsMessage(include) && !KnowsMessages(file)) return "only nodes and core/bus know message types";
  if (!IsOfTree(include)) return "";
  const Arrow* arrow = ArrowOf(file);
  if (arrow == nullptr) return "this folder stands in no row of kArrows";
  const bool is_everywhere = StartsWith(include, "core/errors/") || StartsWith(include, "core/ids/");
  if (StartsWith(include, arrow->folder) || is_everywhere) return "";
  const auto& allowed = arrow->may_include;
  const bool may = std::any_of(allowed.begin(), allowed.end(), [&](const auto& a) { return StartsWith(include, a); });
  return may ? "" : "this arrow points the wrong way";
}

TEST(Structure, IncludesFollowTheArrows) {
  const auto files = test::SourceFiles(kProductFolders);
  ASSERT_GT(files.size(), 50U);
  for (const SourceFile& file : files) {
    if (StartsWith(file.path, "tools/examples/")) continue;  // programs outside of the tree
    for (size_t i = 0; i < file.lines.size(); ++i) {
      const auto include = IncludedFile(file.lines[i]);
      if (!include) continue;
      EXPECT_EQ(Objection(file.path, *include), "") << file.path << ":" << i + 1 << " includes " << *include;
    }
  }
}

TEST(Structure, IncludesOfTheTreeStartAtItsRoot) {
  for (const SourceFile& file : test::AllSourceFiles()) {
    for (const std::string& line : file.lines) {
      const auto include = IncludedFile(line);
      if (!include || line.find('"') == std::string::npos) continue;
      const bool is_generated = *include == "plslam_version.h";
      EXPECT_TRUE(is_generated || IsOfTree(*include) || IsMessage(*include)) << file.path << ": " << line;
    }
  }
}

TEST(Structure, WrongArrowsAreSeen) {
  EXPECT_EQ(Objection("core/geometry/se3.cpp", "core/geometry/se3.h"), "");
  EXPECT_EQ(Objection("core/geometry/se3.cpp", "vector"), "");
  EXPECT_NE(Objection("core/geometry/se3.cpp", "core/features/features.h"), "");
  EXPECT_NE(Objection("core/motion/a.cpp", "core/features/features.h"), "");
  EXPECT_NE(Objection("core/bus/bus.cpp", "player/node/player_node.h"), "");
  EXPECT_NE(Objection("vo_process/tracking/odometry.cpp", "player/options.h"), "");
  EXPECT_NE(Objection("vo_process/tracking/odometry.cpp", "plslam/pose_t.hpp"), "");
  EXPECT_NE(Objection("vo_process/tracking/motion/a.cpp", "vo_process/tracking/odometry.h"), "");
  EXPECT_NE(Objection("vo_process/tracking/motion/a.cpp", "vo_process/tracking/calibration/noise_scale.h"), "");
  EXPECT_NE(Objection("vo_process/node/vo_node.cpp", "lcm/lcm-cpp.hpp"), "");
  EXPECT_EQ(Objection("vo_process/node/vo_node.cpp", "plslam/pose_t.hpp"), "");
  EXPECT_NE(Objection("adapter/body_pose.cpp", "nav_msgs/Odometry.hpp"), "");
  EXPECT_EQ(Objection("core/bus/transport/transport.cpp", "lcm/lcm.h"), "");
  EXPECT_NE(Objection("player/node/player_node.cpp", "tests/support/data_folder.h"), "");
}

}  // namespace
}  // namespace plslam
