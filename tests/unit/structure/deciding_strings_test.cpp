// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <regex>
#include <string>
#include <vector>

#include "tests/unit/structure/source_tree.h"

namespace plslam {
namespace {

/// Readers of texts that others define. Everywhere else a text that decides has a name: an enum with `ChoicesOf`, or a
/// constant of core/run/process_names.h.
const std::vector<std::string> kReadersOfForeignText = {
    "core/config/",                                // YAML
    "lcmtypes/generate_layouts.cpp",               // types of LCM
    "core/datasets/",                              // files and recordings of other programs
    "ros2/arguments.cpp",                          // ROS command lines
    "ros2/domain.cpp",                             // ROS environment variables
    "tools/bridge/",                               // Foxglove's protocol, addresses
    "tools/calibration/live/live_rig.cpp",         // YAML
    "tools/evaluate/evaluate_command.cpp",         // names of its commands
    "tools/evaluate/trajectory_errors.cpp",        // units of numbers
    "tools/evaluate/compare/comparison_text.cpp",  // plural of a column
    "tools/plslam/yaml_to_json.cpp",               // YAML
    "viewer_headless/live/http_server.cpp",        // HTTP
};

bool ComparesWithLiteral(const std::string& line) {
  static const std::regex kComparison(R"re([=!]= "[a-z_0-9]+"|"[a-z_0-9]+" [=!]=)re");
  return std::regex_search(line, kComparison);
}

TEST(DecidingStrings, HaveNames) {
  std::vector<size_t> uses(kReadersOfForeignText.size(), 0);
  for (const auto& file : test::AllSourceFiles()) {
    if (file.path.starts_with("tests/")) continue;
    const auto reader = std::find_if(kReadersOfForeignText.begin(), kReadersOfForeignText.end(),
                                     [&](const std::string& start) { return file.path.starts_with(start); });
    for (size_t i = 0; i < file.lines.size(); ++i) {
      if (!ComparesWithLiteral(file.lines[i])) continue;
      if (reader != kReadersOfForeignText.end()) {
        ++uses[static_cast<size_t>(reader - kReadersOfForeignText.begin())];
      } else {
        ADD_FAILURE() << file.path << ":" << i + 1 << ": compares with a literal; give the value a name";
      }
    }
  }
  for (size_t i = 0; i < uses.size(); ++i)
    EXPECT_GT(uses[i], 0U) << kReadersOfForeignText[i] << " needs no exception";
}

TEST(DecidingStrings, ComparisonsAreSeen) {
  EXPECT_TRUE(ComparesWithLiteral(R"(if (options.merge == "adaptive") return;)"));
  EXPECT_TRUE(ComparesWithLiteral(R"(return "lost" != state;)"));
  EXPECT_FALSE(ComparesWithLiteral(R"(const char* name = "adaptive"; if (text == "") return;)"));
}

}  // namespace
}  // namespace plslam
