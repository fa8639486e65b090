// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

namespace plslam::launcher {

/// "0.1.0", with the git commit where it was known when the build was configured: "0.1.0 (1a2b3c4)".
std::string VersionText();

}  // namespace plslam::launcher
