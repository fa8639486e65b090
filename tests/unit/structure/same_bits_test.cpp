// SPDX-License-Identifier: BSD-3-Clause
// arm64 gives the same bits as amd64 (docs/install.md). The known causes of differences are detected here, on amd64.
#include <gtest/gtest.h>

#include <algorithm>
#include <regex>

#include "tests/unit/structure/source_tree.h"

namespace plslam {
namespace {

using test::SourceFile;

std::string WithoutComments(const SourceFile& file) {
  std::string text;
  for (const std::string& line : file.lines) text += line.substr(0, line.find("//")) + "\n";
  return text;
}

// The C library computes these differently if it is compiled with fused multiply-add. Its sin, exp, pow and the like
// have the same bits.
TEST(SameBits, NoFunctionThatTheCLibraryFuses) {
  static const std::regex kFused(R"(std::(hypot|cbrt|erfc?|exp2|l?gamma|tgamma|fma)f?\()");
  for (const SourceFile& file : test::SourceFiles({"core", "vo_process", "mapping_process", "loop_process"})) {
    std::smatch match;
    const std::string text = WithoutComments(file);
    EXPECT_FALSE(std::regex_search(text, match, kFused))
        << file.path << ": " << match.str() << " (core/geometry/hypot.h)";
  }
}

/// Returns how many of the arguments after the parenthesis at `open` draw a random number.
int DrawingArguments(const std::string& text, size_t open) {
  static const std::regex kDraws(R"(\brandom_?\.|\(random_?\)|\bAny\()");
  int n = 0;
  int depth = 0;
  size_t begin = open + 1;
  for (size_t i = open; i < text.size(); ++i) {
    const bool closes = text[i] == ')' || text[i] == '}' || text[i] == ']';
    depth += text[i] == '(' || text[i] == '{' || text[i] == '[' ? 1 : 0;
    depth -= closes ? 1 : 0;
    if (text[i] == ';' && depth == 1) return 0;  // the head of a loop
    if (depth > 1 || !(text[i] == ',' || closes) || (depth == 1 && closes)) continue;
    n += std::regex_search(text.begin() + static_cast<std::ptrdiff_t>(begin),
                           text.begin() + static_cast<std::ptrdiff_t>(i), kDraws);
    if (depth == 0) return n;
    begin = i + 1;
  }
  return 0;
}

// GCC evaluates arguments from right to left on amd64 and from left to right on arm64.
TEST(SameBits, NoListOfArgumentsOfAWorldDrawsTwice) {
  for (const SourceFile& file : test::SourceFiles({"core/datasets/synthetic", "tests/tools"})) {
    const std::string text = WithoutComments(file);
    for (size_t i = text.find('('); i != std::string::npos; i = text.find('(', i + 1)) {
      EXPECT_LT(DrawingArguments(text, i), 2) << file.path << ": " << text.substr(i, 80);
    }
  }
}

}  // namespace
}  // namespace plslam
