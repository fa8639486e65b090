// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <set>

#include "tests/support/data_folder.h"

namespace plslam {
namespace {

namespace fs = std::filesystem;

constexpr const char* kLicence = "SPDX-License-Identifier: BSD-3-Clause";

/// Returns the prefix of a source's comments; empty if the file is no source: a document, an image, a table.
std::string CommentOf(const fs::path& path, bool is_script) {
  static const std::set<std::string> kSlashes{".h", ".cpp", ".js", ".mjs", ".lcm", ".java"};
  static const std::set<std::string> kHashes{".py", ".cmake", ".sh"};
  if (kSlashes.contains(path.extension())) return "// ";
  const bool is_unit = path.stem().extension() == ".service" || path.stem().extension() == ".target";
  const bool hashes =
      kHashes.contains(path.extension()) || path.filename() == "CMakeLists.txt" || is_unit || is_script;
  return hashes ? "# " : "";
}

TEST(Licence, IsTheFirstLineOfEverySource) {
  int n_sources = 0;
  for (auto entry = fs::recursive_directory_iterator(test::SourceFolder());
       entry != fs::recursive_directory_iterator(); ++entry) {
    const fs::path& path = entry->path();
    // Builds are beside the sources, hidden folders belong to other programs, and recordings end in .lcm, too.
    const bool is_foreign = path.filename() == "build" || path.filename().string().starts_with(".") ||
                            path.filename() == "node_modules" || path == test::SourceFolder() / "tests/golden" ||
                            path.filename() == "__pycache__";
    if (is_foreign && entry->is_directory()) entry.disable_recursion_pending();
    if (!entry->is_regular_file()) continue;
    std::ifstream file(path);
    std::string first;
    std::getline(file, first);
    const bool is_script = first.starts_with("#!");
    const std::string comment = CommentOf(path, is_script);
    if (comment.empty()) continue;
    if (is_script) std::getline(file, first);
    EXPECT_EQ(first, comment + kLicence) << path.lexically_relative(test::SourceFolder());
    ++n_sources;
  }
  EXPECT_GT(n_sources, 1000) << "the tree has not been found";
}

}  // namespace
}  // namespace plslam
