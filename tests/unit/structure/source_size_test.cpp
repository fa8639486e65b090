// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "tests/unit/structure/source_tree.h"

namespace plslam {
namespace {

constexpr size_t kMaxLines = 600;
constexpr size_t kMaxMainLines = 60;

TEST(Structure, FilesStaySmall) {
  for (const auto& file : test::AllSourceFiles()) {
    const size_t limit = file.path.ends_with("/main.cpp") ? kMaxMainLines : kMaxLines;
    EXPECT_LE(file.lines.size(), limit) << file.path;
  }
}

TEST(Structure, HeadersAreIncludedOnce) {
  for (const auto& file : test::AllSourceFiles()) {
    if (!file.path.ends_with(".h")) continue;
    // After the line of the licence.
    ASSERT_GE(file.lines.size(), 2U) << file.path;
    EXPECT_EQ(file.lines[1], "#pragma once") << file.path;
  }
}

TEST(Structure, NothingIsLeftForLater) {
  const std::string marks[] = {std::string("TO") + "DO", std::string("FIX") + "ME", std::string("X") + "XX "};
  for (const auto& file : test::AllSourceFiles()) {
    for (size_t i = 0; i < file.lines.size(); ++i) {
      for (const std::string& mark : marks) {
        EXPECT_EQ(file.lines[i].find(mark), std::string::npos) << file.path << ":" << i + 1;
      }
    }
  }
}

}  // namespace
}  // namespace plslam
