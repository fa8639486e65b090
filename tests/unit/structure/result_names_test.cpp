// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "core/run/result_files.h"
#include "tests/unit/structure/source_tree.h"

namespace plslam {
namespace {

/// Returns whether a literal is the path of a result file, not a sentence about one.
bool IsResultPath(const std::string& literal) {
  const std::string name = literal.substr(literal.rfind('/') + 1);
  const bool is_sentence = literal.find(' ') != std::string::npos;
  return !is_sentence && (name == result_file::kMap || std::ranges::find(kResultFiles, name) != kResultFiles.end());
}

/// Returns the result files that a line spells.
std::vector<std::string> SpelledIn(const std::string& line) {
  std::vector<std::string> spelled;
  for (size_t begin = line.find('"'); begin != std::string::npos; begin = line.find('"', begin + 1)) {
    const size_t end = line.find('"', begin + 1);
    if (end == std::string::npos) break;
    const std::string literal = line.substr(begin + 1, end - begin - 1);
    if (IsResultPath(literal)) spelled.push_back(literal);
    begin = end;
  }
  return spelled;
}

TEST(ResultFiles, AreNamedInOnePlace) {
  size_t n_owners = 0;
  for (const auto& file : test::AllSourceFiles()) {
    if (file.path.starts_with("tests/")) continue;
    for (size_t i = 0; i < file.lines.size(); ++i) {
      const auto spelled = SpelledIn(file.lines[i]);
      if (file.path == "core/run/result_files.h") {
        n_owners += spelled.size();
        continue;
      }
      EXPECT_TRUE(spelled.empty()) << file.path << ":" << i + 1 << ": " << testing::PrintToString(spelled)
                                   << ": use a constant of core/run/result_files.h";
    }
  }
  EXPECT_EQ(n_owners, kResultFiles.size() + 1);
}

TEST(ResultFiles, SpelledNamesAreSeen) {
  EXPECT_EQ(SpelledIn(R"(Read(out + "/summary.json", "a", "poses.csv");)").size(), 2U);
  EXPECT_TRUE(SpelledIn(R"(Print("covariance.txt of the viewer", "my_map.yaml");)").empty());
}

}  // namespace
}  // namespace plslam
