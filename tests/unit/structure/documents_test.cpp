// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cctype>
#include <cmath>
#include <filesystem>
#include <map>
#include <regex>
#include <set>
#include <sstream>

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

/// The anchor that GitHub gives to a heading; MkDocs gives the same one unless words are apart by more than one
/// character.
std::string AnchorOf(const std::string& heading) {
  static const std::regex kLink(R"(\[([^\]]*)\]\([^)]*\))");
  std::string anchor;
  for (const char c : std::regex_replace(heading, kLink, "$1")) {
    if (std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_' || c == '-') {
      anchor += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    } else if (c == ' ') {
      anchor += '-';
    }
  }
  return anchor;
}

/// Anchors of a document; a heading that is repeated has a number.
std::set<std::string> AnchorsOf(const fs::path& document) {
  std::istringstream text(test::ReadText(document));
  std::set<std::string> anchors;
  std::map<std::string, int> uses;
  bool in_block = false;
  for (std::string line; std::getline(text, line);) {
    if (line.starts_with("```")) in_block = !in_block;
    const size_t level = line.find_first_not_of('#');
    if (in_block || level == 0 || level == std::string::npos || line[level] != ' ') continue;
    const std::string anchor = AnchorOf(line.substr(level + 1));
    const int n = uses[anchor]++;
    anchors.insert(n == 0 ? anchor : fmt::format("{}-{}", anchor, n));
  }
  return anchors;
}

TEST(Documents, LinksLeadToHeadings) {
  EXPECT_EQ(AnchorOf("KITTI, EuRoC [`warnings`](a.md) x_y"), "kitti-euroc-warnings-x_y");
  int n_links = 0;
  for (const fs::path& document : Documents()) {
    const std::string text = test::ReadText(document);
    for (const std::string& link : Matches(text, R"(\]\(([^)#:]*#[^)]+)\))")) {
      const size_t mark = link.find('#');
      const fs::path target = mark == 0 ? document : document.parent_path() / link.substr(0, mark);
      if (target.extension() != ".md" || !fs::exists(target)) continue;
      ++n_links;
      EXPECT_TRUE(AnchorsOf(target).contains(link.substr(mark + 1))) << document << " links to " << link;
    }
  }
  EXPECT_GT(n_links, 50);
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

/// Cells of a row of a table in Markdown, without spaces around them and without bold marks.
std::vector<std::string> CellsOf(const std::string& line) {
  std::vector<std::string> cells;
  std::istringstream text(line);
  std::string cell;
  std::getline(text, cell, '|');
  while (std::getline(text, cell, '|')) {
    std::erase(cell, '*');
    const size_t begin = cell.find_first_not_of(' ');
    cells.push_back(begin == std::string::npos ? "" : cell.substr(begin, cell.find_last_not_of(' ') + 1 - begin));
  }
  return cells;
}

/// The rows of the tables of a document that begin with this cell, in their order.
std::vector<std::vector<std::string>> RowsOf(const std::string& document, const std::string& first_cell) {
  std::vector<std::vector<std::string>> rows;
  std::istringstream text(document);
  for (std::string line; std::getline(text, line);) {
    if (line.starts_with("| " + first_cell)) rows.push_back(CellsOf(line));
  }
  return rows;
}

/// The number of the README, with as many digits as it has, is that of the results.
void ExpectRounded(const std::string& shown, const std::string& exact, const std::string& of) {
  const size_t point = shown.find('.');
  const int digits = point == std::string::npos ? 0 : static_cast<int>(shown.size() - point) - 1;
  EXPECT_NEAR(std::stod(shown), std::stod(exact), 0.5001 * std::pow(10.0, -digits)) << of;
}

TEST(Documents, ReadmeHasTheFiguresOfTheResults) {
  const std::string readme = test::ReadText(test::SourceFolder() / "README.md");
  const std::string results = test::ReadText(test::SourceFolder() / "docs/results.md");
  const std::vector<std::string> head = RowsOf(readme, "sequence").at(0);
  for (const auto& [name, sequence] : {std::pair{"KITTI 03", "kitti_03"}, std::pair{"EuRoC MH_01", "euroc_MH_01_a"},
                                       std::pair{"TartanAir P000", "tartanair2_10"}}) {
    const std::vector<std::string> row = RowsOf(readme, name).at(0);
    const std::vector<std::vector<std::string>> found = RowsOf(results, std::string(sequence) + " |");
    const std::vector<std::string>& errors = found.at(0);
    const std::vector<std::string>& times = found.at(1);
    std::smatch ours;
    ASSERT_TRUE(std::regex_search(row[1], ours, std::regex(R"(^([\d.]+) m, (\d+) \+ (\d+) ms$)"))) << row[1];
    ExpectRounded(ours[1], errors.at(4), row[0] + ", ATE");
    ExpectRounded(ours[2], times.at(1), row[0] + ", tracking");
    ExpectRounded(ours[3], times.at(7), row[0] + ", player");
    for (size_t i = 2; i < row.size(); ++i) {
      const std::string peer = head[i].substr(0, head[i].find(" ("));
      std::smatch shown, exact;
      if (row[i] == "lost") {
        EXPECT_THAT(errors.at(9), testing::HasSubstr(peer + " lost")) << row[0];
        continue;
      }
      ASSERT_TRUE(std::regex_search(row[i], shown, std::regex(R"(^([\d.]+) m(?:, (\d+) ms)?$)"))) << row[i];
      ASSERT_TRUE(std::regex_search(errors.at(9), exact, std::regex(peer + R"( ([\d.]+)(?: · (\d+))?)"))) << peer;
      ExpectRounded(shown[1], exact[1], row[0] + ", " + peer);
      EXPECT_TRUE(!shown[2].matched || shown[2] == exact[2]) << row[0] << ", " << peer;
    }
  }
}

}  // namespace
}  // namespace plslam
