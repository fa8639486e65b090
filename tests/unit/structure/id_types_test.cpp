// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <map>
#include <regex>
#include <string>

#include "tests/unit/structure/source_tree.h"

namespace plslam {
namespace {

using test::SourceFile;

// Pairs of parameters that a caller could exchange unnoticed, by file and names, and why they are left.
const std::map<std::string, std::string> kExchangeable = {
    {"core/map/map.h: a, b", "symmetric"},
    {"loop_process/map_path.h: a, b", "symmetric"},
    {"mapping_process/insertion/observations.h: a, b", "symmetric"},
    {"tools/evaluate/figures/pair_figure.h: a, b", "symmetric"},
    {"core/run/frame_tally.h: keyframe_id, sign", "an id and a sign"},
    {"loop_process/loop_verification.h: old_keyframe_id, keyframe_id", "both are keyframes; the older one is first"}};

/// Returns the text of a file in one line, without comments.
std::string Declarations(const SourceFile& file) {
  std::string text;
  for (const std::string& line : file.lines) text += line.substr(0, line.find("//")) + " ";
  return text;
}

// A function of two ids of one type, or of an id that is a mere number beside another number, can be called with both
// exchanged, and compiles. Ids are types of their own (core/ids).
TEST(Structure, NoTwoIdsOfOneTypeInARow) {
  static const std::regex kPair(
      R"((?:const )?\b(int64_t|\w+Id)\b&? (\w+)(?: = [^,()]+)?,\s*(?:const )?(?=\1&? (\w+)\b))");
  static const std::regex kIdName(R"(a|b|id|source|session|publisher|reader|keyframe|landmark|\w+_(?:id|session))");
  std::map<std::string, int> found;
  for (const SourceFile& file : test::AllSourceFiles()) {
    if (!file.path.ends_with(".h") || file.path.starts_with("tests/")) continue;
    const std::string text = Declarations(file);
    for (std::sregex_iterator pair(text.begin(), text.end(), kPair), end; pair != end; ++pair) {
      const bool is_number = (*pair)[1] == "int64_t";
      const std::string first = (*pair)[2], second = (*pair)[3];
      if (is_number && !std::regex_match(first, kIdName) && !std::regex_match(second, kIdName)) continue;
      const std::string name = file.path + ": " + first + ", " + second;
      ++found[name];
      EXPECT_TRUE(kExchangeable.contains(name)) << name << " of type " << (*pair)[1] << " can be exchanged";
    }
  }
  for (const auto& [name, reason] : kExchangeable) {
    EXPECT_TRUE(found.contains(name)) << name << " (" << reason << ") is no longer there: remove the row";
  }
}

}  // namespace
}  // namespace plslam
