// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace plslam::test {

/// A text file of the tree.
struct SourceFile {
  std::string path;  ///< from the root, with slashes
  std::vector<std::string> lines;
};

/// All .h and .cpp files of `folders`, sorted by path.
std::vector<SourceFile> SourceFiles(const std::vector<std::string>& folders);

/// Returns the files of all folders that have source files.
std::vector<SourceFile> AllSourceFiles();

std::string ReadText(const std::filesystem::path& path);

}  // namespace plslam::test
