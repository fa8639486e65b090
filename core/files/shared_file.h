// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace plslam {

/// Returns the absolute names of a folder without a trailing slash: as given and, if that is through a link, as
/// resolved. The files of a dataset are named after its folder, and either name may be the benchmark's.
std::vector<std::filesystem::path> NamesOfFolder(const std::filesystem::path& folder);

/// Returns the folder of the running program; empty if the system does not provide it.
std::filesystem::path ProgramFolder();

/// Returns `share/plslam/NAME` beside that folder, for the files that are installed with the programs; the file may not
/// exist. Empty if the system does not provide the folder.
std::filesystem::path SharedFile(const std::string& name);

/// Finds a file that is installed with the programs: returns `name` unchanged if there is such a file, else the shared
/// one. Returns `name` if neither exists.
std::string FindSharedFile(const std::string& name);

}  // namespace plslam
