// SPDX-License-Identifier: BSD-3-Clause
// The documents as a static site.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "tests/support/data_folder.h"
#include "tests/support/shell.h"
#include "tests/support/text_file.h"

namespace plslam {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

/// Values of an attribute in the tags of a page.
std::set<std::string> Attributes(const std::string& html, const std::string& name) {
  std::set<std::string> values;
  const std::string begin = " " + name + "=\"";
  for (size_t at = html.find(begin); at != std::string::npos; at = html.find(begin, at)) {
    at += begin.size();
    values.insert(html.substr(at, html.find('"', at) - at));
  }
  return values;
}

bool IsElsewhere(const std::string& link) { return link.find(':') != std::string::npos || link.starts_with("//"); }

/// Stands for the site that scripts/document writes.
class Site : public testing::Test {
 protected:
  void Write() {
    const std::string script = (test::SourceFolder() / "scripts" / "document").string();
    result_ = test::Shell(folder_, "'" + script + "' --site '" + site_.string() + "'");
    if (result_.exit_code != 0) return;
    for (const auto& entry : fs::recursive_directory_iterator(site_)) {
      // The page 404 is for any folder of a server, and its links begin at the server's root.
      if (entry.path().extension() != ".html" || entry.path().filename() == "404.html") continue;
      pages_[entry.path()] = ReadText(entry.path().string());
    }
  }

  const ScratchFolder folder_;
  const fs::path site_ = folder_.Path("site");
  std::map<fs::path, std::string> pages_;
  test::ShellResult result_;
};

TEST_F(Site, HasAllPagesPicturesLinksAndAnchors) {
  PLSLAM_REQUIRE_PROGRAM("mkdocs");
  Write();
  ASSERT_EQ(result_.exit_code, 0) << result_.out << result_.error;
  std::map<fs::path, std::set<std::string>> anchors;
  for (const auto& [path, html] : pages_) anchors[path] = Attributes(html, "id");
  int n_links = 0;
  for (const auto& [path, html] : pages_) {
    std::set<std::string> links = Attributes(html, "href");
    links.merge(Attributes(html, "src"));
    for (const std::string& link : links) {
      if (IsElsewhere(link) || link.empty()) continue;
      ++n_links;
      const size_t mark = link.find('#');
      const std::string file = link.substr(0, mark);
      const fs::path target = file.empty() ? path : (path.parent_path() / file).lexically_normal();
      EXPECT_TRUE(fs::exists(target)) << path << " links to " << link;
      if (mark == std::string::npos || mark + 1 == link.size() || !anchors.contains(target)) continue;
      EXPECT_TRUE(anchors[target].contains(link.substr(mark + 1))) << path << " links to " << link;
    }
  }
  EXPECT_GT(n_links, 500);
  const std::string home = ReadText((site_ / "index.html").string());
  for (const auto& entry : fs::recursive_directory_iterator(test::SourceFolder() / "docs")) {
    if (entry.path().extension() != ".md") continue;
    const fs::path page = entry.path().lexically_relative(test::SourceFolder()).replace_extension(".html");
    EXPECT_TRUE(fs::exists(site_ / page)) << page;
    EXPECT_THAT(home, HasSubstr("href=\"" + page.string() + "\"")) << "add it to `nav` in mkdocs.yml";
  }
}

TEST_F(Site, IsForPhonesSearchableAndComplete) {
  PLSLAM_REQUIRE_PROGRAM("mkdocs");
  Write();
  ASSERT_EQ(result_.exit_code, 0) << result_.out << result_.error;
  EXPECT_GT(pages_.size(), 30U);
  for (const auto& [path, html] : pages_) {
    EXPECT_THAT(html, HasSubstr("<meta name=\"viewport\" content=\"width=device-width")) << path;
    for (const std::string& file : Attributes(html, "src"))
      EXPECT_FALSE(IsElsewhere(file)) << path << " loads " << file;
  }
  const std::string index = ReadText((site_ / "search" / "search_index.json").string());
  EXPECT_THAT(index, HasSubstr("\"location\":\"docs/tutorial.html"));
  EXPECT_THAT(index, HasSubstr("multicast"));
}

}  // namespace
}  // namespace plslam
