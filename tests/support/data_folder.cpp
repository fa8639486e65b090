// SPDX-License-Identifier: BSD-3-Clause
#include "tests/support/data_folder.h"

#include <cstdlib>

namespace plslam::test {

std::optional<std::filesystem::path> DataFolder(const std::string& sequence) {
  const char* root = std::getenv("PLSLAM_DATA");
  std::filesystem::path folder = std::filesystem::path(root != nullptr ? root : PLSLAM_DEFAULT_DATA) / sequence;
  if (!std::filesystem::exists(folder)) return std::nullopt;
  return folder;
}

std::filesystem::path SourceFolder() { return PLSLAM_SOURCE_DIR; }

std::filesystem::path BinaryFolder() { return PLSLAM_BINARY_DIR; }

}  // namespace plslam::test
