// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>

namespace plslam {

/// The folder of the running program; empty where the system does not tell.
std::filesystem::path ProgramFolder();

/// `share/plslam/NAME` beside that folder, where what comes with the programs is; there may be no such file. Empty
/// where the system does not tell.
std::filesystem::path SharedFile(const std::string& name);

/// Where a file that comes with the programs is: `name` as it stands if there is such a file, else the shared one.
/// Returns `name` where there is neither.
std::string FindSharedFile(const std::string& name);

}  // namespace plslam
