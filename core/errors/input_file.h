// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <fstream>
#include <string>

namespace plslam {

/// Opens a file or a pipe for reading, binary. Throws std::runtime_error "PATH: cannot be read: REASON" where there
/// is none, where it is a folder, or where permission is missing.
std::ifstream OpenInput(const std::string& path);

/// Why `OpenInput` would refuse, without the path ("cannot be read: No such file or directory"); empty where it would
/// not.
std::string WhyUnreadable(const std::string& path);

}  // namespace plslam
