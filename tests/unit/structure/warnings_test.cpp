// SPDX-License-Identifier: BSD-3-Clause
#include <gmock/gmock.h>

#include <map>
#include <regex>
#include <set>
#include <sstream>

#include "core/run/run_warnings.h"
#include "tests/support/data_folder.h"
#include "tests/unit/structure/source_tree.h"

namespace plslam {
namespace {

/// The first and the last cells of the first table of docs/lab/warnings.md: codes and tests, without quotes.
std::map<std::string, std::string> TableOfWarnings() {
  static const std::regex kRow(R"(\| `([a-z0-9_]+)` \|.*\| `([A-Za-z0-9]+\.[A-Za-z0-9]+)` \|)");
  std::istringstream lines(test::ReadText(test::SourceFolder() / "docs/lab/warnings.md"));
  std::map<std::string, std::string> tests;
  std::smatch match;
  for (std::string line; std::getline(lines, line);) {
    if (std::regex_match(line, match, kRow)) tests[match[1]] = match[2];
  }
  return tests;
}

/// The codes that processes publish, and those that are derived at the end.
std::set<std::string> CodesOfTheSource() {
  static const std::regex kWarn(R"RE(\bWarn\(\s*"([a-z0-9_]+)",)RE");
  std::set<std::string> codes;
  for (const std::string& code : WarningCodes()) codes.insert(code);
  for (const test::SourceFile& file : test::AllSourceFiles()) {
    if (file.path.starts_with("tests/")) continue;
    std::string text;
    for (const std::string& line : file.lines) text += line + '\n';
    for (std::sregex_iterator found(text.begin(), text.end(), kWarn), end; found != end; ++found) {
      codes.insert((*found)[1]);
    }
  }
  return codes;
}

TEST(Warnings, TableHasEachCodeAndNoOther) {
  std::set<std::string> described;
  for (const auto& [code, test] : TableOfWarnings()) described.insert(code);
  const std::set<std::string> codes = CodesOfTheSource();
  EXPECT_TRUE(codes.contains("masks_unused") && codes.contains("recording_stopped")) << "published ones are found";
  EXPECT_THAT(described, testing::ElementsAreArray(codes));
}

TEST(Warnings, TestsOfTheTableExist) {
  std::set<std::string> tests;
  static const std::regex kTest(R"(\bTEST(_F|_P)?\((\w+), (\w+)\))");
  for (const test::SourceFile& file : test::AllSourceFiles()) {
    std::smatch match;
    for (const std::string& line : file.lines) {
      if (std::regex_search(line, match, kTest)) tests.insert(match[2].str() + "." + match[3].str());
    }
  }
  for (const auto& [code, test] : TableOfWarnings()) EXPECT_TRUE(tests.contains(test)) << code << ": " << test;
}

}  // namespace
}  // namespace plslam
