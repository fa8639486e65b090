// SPDX-License-Identifier: BSD-3-Clause
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <regex>
#include <set>

#include "tests/support/data_folder.h"
#include "tests/unit/structure/source_tree.h"

namespace plslam {
namespace {

namespace fs = std::filesystem;

std::vector<fs::path> Documents() {
  std::vector<fs::path> documents = {test::SourceFolder() / "README.md", test::SourceFolder() / "CHANGELOG.md"};
  for (const char* folder : {"docs", "lcmtypes"}) {
    for (const auto& entry : fs::recursive_directory_iterator(test::SourceFolder() / folder)) {
      if (entry.path().extension() == ".md") documents.push_back(entry.path());
    }
  }
  return documents;
}

std::set<std::string> Matches(const std::string& text, const std::string& pattern) {
  const std::regex regex(pattern);
  std::set<std::string> found;
  for (std::sregex_iterator it(text.begin(), text.end(), regex), end; it != end; ++it) found.insert((*it)[1]);
  return found;
}

TEST(Documents, ScriptsTheyNameExistAndCanBeRun) {
  for (const fs::path& document : Documents()) {
    for (const std::string& script : Matches(test::ReadText(document), R"((scripts/[a-z_]+)\b(?!\.))")) {
      const fs::path path = test::SourceFolder() / script;
      ASSERT_TRUE(fs::exists(path)) << document << " names " << script;
      EXPECT_NE(fs::status(path).permissions() & fs::perms::owner_exec, fs::perms::none) << script;
    }
  }
}

TEST(Documents, LinksLeadToFiles) {
  for (const fs::path& document : Documents()) {
    for (const std::string& link : Matches(test::ReadText(document), R"(\]\(([^)#:]+)[)#])")) {
      EXPECT_TRUE(fs::exists(document.parent_path() / link)) << document << " links to " << link;
    }
  }
}

TEST(Documents, ProgramsThatTheyRunAreBuilt) {
  std::set<std::string> programs;
  for (const fs::path& document : Documents())
    programs.merge(Matches(test::ReadText(document), R"(build/release/bin/(\w+))"));
  EXPECT_THAT(programs, testing::IsSupersetOf({"plslam", "player", "vo_process", "viewer_headless"}));
  for (const std::string& program : programs) {
    EXPECT_TRUE(fs::exists(test::BinaryFolder() / program)) << "a document runs " << program;
  }
}

TEST(Documents, FirstScreenOfTheReadmeHasTwoCommands) {
  const std::string readme = test::ReadText(test::SourceFolder() / "README.md");
  const size_t begin = readme.find("```"), end = readme.find("```", begin + 3);
  ASSERT_NE(end, std::string::npos);
  std::istringstream block(readme.substr(readme.find('\n', begin) + 1, end - readme.find('\n', begin) - 1));
  std::vector<std::string> commands;
  for (std::string line; std::getline(block, line);)
    commands.push_back(line.substr(0, line.find_last_not_of(' ', line.find('#') - 1) + 1));
  EXPECT_THAT(commands, testing::ElementsAre("scripts/demo", "scripts/test"));
}

}  // namespace
}  // namespace plslam
