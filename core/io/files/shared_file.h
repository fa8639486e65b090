// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace plslam {

/// What a folder is called, whole and without a slash at the end: as it was given, and, where that is through a link,
/// as it really is. A dataset's name tells what belongs to it, and either may be the one that the benchmark gave it.
std::vector<std::filesystem::path> NamesOfFolder(const std::filesystem::path& folder);

/// The folder of the running program; empty where the system does not tell.
std::filesystem::path ProgramFolder();

/// `share/plslam/NAME` beside that folder, where what comes with the programs is; there may be no such file. Empty
/// where the system does not tell.
std::filesystem::path SharedFile(const std::string& name);

/// Where a file that comes with the programs is: `name` as it stands if there is such a file, else the shared one.
/// Returns `name` where there is neither.
std::string FindSharedFile(const std::string& name);

}  // namespace plslam
