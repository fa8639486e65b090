// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <vector>

namespace plslam {

/// What a folder is called, whole and without a slash at the end: as it was given, and, where that is through a link,
/// as it really is. A dataset's name tells what belongs to it, and either may be the one that the benchmark gave it.
std::vector<std::filesystem::path> NamesOfFolder(const std::filesystem::path& folder);

}  // namespace plslam
