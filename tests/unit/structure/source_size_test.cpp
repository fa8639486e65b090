// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <regex>
#include <string>
#include <vector>

#include "tests/unit/structure/source_tree.h"

namespace plslam {
namespace {

constexpr size_t kMaxLines = 600;
constexpr size_t kMaxMainLines = 60;
constexpr int kMaxMembers = 20;

/// Returns the number of data members (names that end in '_') of each class in the lines of a header.
std::map<std::string, int> MembersOfClasses(const std::vector<std::string>& lines) {
  static const std::regex kClass(R"(\s*(?:class|struct) ([\w:]+)[^;]*\{\s*)");
  static const std::regex kMember(
      R"(\s+(?!return |using |friend )[\w:<>,\s*&()\[\].]*?[\s&*>]((?:\w+_, )*\w+_)( =.*|\{.*\})?;)");
  struct Open {
    std::string name;
    long depth = 0;
  };
  std::map<std::string, int> members;
  std::vector<Open> open;
  long depth = 0;
  for (const std::string& line : lines) {
    const size_t comment = line.find("//");
    std::string code = line.substr(0, comment);
    code.erase(code.find_last_not_of(' ') + 1);
    std::smatch match;
    if (std::regex_match(code, match, kClass)) {
      open.push_back({match[1], depth});
    } else if (!open.empty() && depth == open.back().depth + 1 && std::regex_match(code, match, kMember)) {
      const std::string names = match[1];
      members[open.back().name] += 1 + static_cast<int>(std::count(names.begin(), names.end(), ','));
    }
    depth += std::count(code.begin(), code.end(), '{') - std::count(code.begin(), code.end(), '}');
    while (!open.empty() && depth <= open.back().depth) open.pop_back();
  }
  return members;
}

TEST(Structure, FilesStaySmall) {
  for (const auto& file : test::AllSourceFiles()) {
    const size_t limit = file.path.ends_with("/main.cpp") ? kMaxMainLines : kMaxLines;
    EXPECT_LE(file.lines.size(), limit) << file.path;
  }
}

TEST(Structure, ClassesHaveFewMembers) {
  for (const auto& file : test::AllSourceFiles()) {
    if (!file.path.ends_with(".h") || file.path.starts_with("tests/")) continue;
    for (const auto& [name, n] : MembersOfClasses(file.lines)) {
      EXPECT_LE(n, kMaxMembers) << file.path << ": " << name;
    }
  }
}

TEST(Structure, MembersOfClassesAreCounted) {
  const std::vector<std::string> header = {"class Outer {",
                                           " public:",
                                           "  explicit Outer(int a) : a_(a) {}",
                                           "  struct Inner {",
                                           "    std::map<int, Value> inner_;  ///< with `b_;`",
                                           "  };",
                                           "  bool has_a() const { return a_ > 0; }",
                                           " private:",
                                           "  int a_;",
                                           "  std::function<void(int)> f_, g_;",
                                           "  // int none_;",
                                           "  State state_ = State::kOpen;",
                                           "  std::atomic<bool> stops_{false};",
                                           "};"};
  const std::map<std::string, int> members = MembersOfClasses(header);
  EXPECT_EQ(members.at("Outer"), 5);
  EXPECT_EQ(members.at("Inner"), 1);
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
