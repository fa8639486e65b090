// SPDX-License-Identifier: BSD-3-Clause
#include "core/files/shared_file.h"

#include <system_error>

namespace plslam {

std::vector<std::filesystem::path> NamesOfFolder(const std::filesystem::path& folder) {
  std::filesystem::path given = std::filesystem::absolute(folder).lexically_normal();
  if (!given.has_filename()) given = given.parent_path();
  std::vector<std::filesystem::path> names{given};
  std::filesystem::path real = std::filesystem::weakly_canonical(folder);
  if (real != given) names.push_back(std::move(real));
  return names;
}

namespace fs = std::filesystem;

fs::path ProgramFolder() {
  std::error_code error;
  return fs::read_symlink("/proc/self/exe", error).parent_path();
}

fs::path SharedFile(const std::string& name) {
  const fs::path folder = ProgramFolder();
  return folder.empty() ? fs::path() : folder.parent_path() / "share" / "plslam" / name;
}

std::string FindSharedFile(const std::string& name) {
  std::error_code error;
  if (fs::exists(name, error)) return name;
  const fs::path shared = SharedFile(name);
  return fs::exists(shared, error) ? shared.string() : name;
}

}  // namespace plslam
