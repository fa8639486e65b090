// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <fstream>
#include <string>

namespace plslam::test {

/// Writes a file for `bus.key_file` with a key of this digit, and returns its name.
inline std::string KeyFile(const std::filesystem::path& folder, char digit) {
  const std::filesystem::path path = folder / (std::string("key_") + digit);
  std::ofstream(path) << std::string(64, digit) << '\n';
  return path.string();
}

}  // namespace plslam::test
