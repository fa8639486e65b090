// SPDX-License-Identifier: BSD-3-Clause
#include "core/io/files/names_of_folder.h"

namespace plslam {

std::vector<std::filesystem::path> NamesOfFolder(const std::filesystem::path& folder) {
  std::filesystem::path given = std::filesystem::absolute(folder).lexically_normal();
  if (!given.has_filename()) given = given.parent_path();
  std::vector<std::filesystem::path> names{given};
  std::filesystem::path real = std::filesystem::weakly_canonical(folder);
  if (real != given) names.push_back(std::move(real));
  return names;
}

}  // namespace plslam
