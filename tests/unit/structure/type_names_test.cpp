// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <map>
#include <regex>
#include <string>
#include <utility>

#include "tests/unit/structure/source_tree.h"

namespace plslam {
namespace {

using test::SourceFile;

// Two types of one name in one namespace are one type to the linker, in whichever files they are.
TEST(Structure, ATypeIsDefinedInOneHeader) {
  static const std::regex kNamespace(R"(namespace (plslam[\w:]*) \{)");
  static const std::regex kType(R"((?:struct|class|enum class) (\w+)(?: final)?(?: :.*)? ?\{.*)");
  std::map<std::pair<std::string, std::string>, std::string> defined_in;
  for (const SourceFile& file : test::AllSourceFiles()) {
    if (!file.path.ends_with(".h") || file.path.starts_with("tests/")) continue;
    std::string space;
    for (const std::string& line : file.lines) {
      std::smatch match;
      if (std::regex_match(line, match, kNamespace)) space = match[1];
      if (!std::regex_match(line, match, kType)) continue;
      const auto [known, is_new] = defined_in.try_emplace({space, match[1]}, file.path);
      EXPECT_TRUE(is_new || known->second == file.path)
          << space << "::" << match[1] << " is defined in " << known->second << " and in " << file.path;
    }
  }
  EXPECT_GT(defined_in.size(), 300U);
}

// The namespace of a file names its process or tool; shared files are in plain plslam, or a part of it.
TEST(Structure, ProcessesAndToolsHaveNamespacesOfTheirOwn) {
  const std::map<std::string, std::string> spaces = {{"vo_process/", "plslam::vo"},
                                                     {"mapping_process/", "plslam::mapping"},
                                                     {"loop_process/", "plslam::loop"},
                                                     {"player/", "plslam::player"},
                                                     {"adapter/", "plslam::adapter"},
                                                     {"camera/", "plslam::camera"},
                                                     {"viewer_headless/", "plslam::viewer"},
                                                     {"dense_process/", "plslam::dense"},
                                                     {"tools/plslam/", "plslam::launcher"},
                                                     {"tools/export/", "plslam::exports"},
                                                     {"tools/doctor/", "plslam::doctor"},
                                                     {"tools/bridge/", "plslam::bridge"},
                                                     {"ros2/", "plslam::ros2"},
                                                     {"core/robot/", "plslam::robot"},
                                                     {"core/stream/", "plslam::stream"}};
  for (const SourceFile& file : test::AllSourceFiles()) {
    for (const auto& [folder, space] : spaces) {
      if (!file.path.starts_with(folder)) continue;
      for (const std::string& line : file.lines) {
        if (!line.starts_with("namespace plslam") || line == "namespace plslam {") continue;
        EXPECT_TRUE(line.starts_with("namespace " + space) || line.starts_with("namespace plslam::archive") ||
                    line.starts_with("namespace plslam::bus") || line.starts_with("namespace plslam::film_stream"))
            << file.path << ": " << line;
      }
    }
  }
}

}  // namespace
}  // namespace plslam
