// SPDX-License-Identifier: BSD-3-Clause
#include "tests/unit/structure/source_tree.h"

#include <algorithm>
#include <fstream>
#include <stdexcept>

#include "tests/support/data_folder.h"

namespace plslam::test {

std::vector<SourceFile> SourceFiles(const std::vector<std::string>& folders) {
  std::vector<SourceFile> files;
  for (const std::string& folder : folders) {
    for (const auto& entry : std::filesystem::recursive_directory_iterator(SourceFolder() / folder)) {
      if (entry.path().extension() != ".h" && entry.path().extension() != ".cpp") continue;
      SourceFile file{entry.path().lexically_relative(SourceFolder()).generic_string(), {}};
      std::ifstream stream(entry.path());
      for (std::string line; std::getline(stream, line);) file.lines.push_back(line);
      files.push_back(std::move(file));
    }
  }
  std::sort(files.begin(), files.end(), [](const auto& a, const auto& b) { return a.path < b.path; });
  return files;
}

std::vector<SourceFile> AllSourceFiles() {
  return SourceFiles({"lcmtypes", "core", "adapter", "camera", "player", "vo_process", "mapping_process",
                      "loop_process", "viewer_headless", "dense_process", "ros2", "tools", "tests"});
}

std::string ReadText(const std::filesystem::path& path) {
  std::ifstream stream(path);
  if (!stream) throw std::runtime_error(path.string() + " cannot be read");
  return {std::istreambuf_iterator<char>(stream), {}};
}

}  // namespace plslam::test
