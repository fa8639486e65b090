// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

namespace plslam {

/// Returns "0.3.0", with the git commit if it was known when the build was configured: "0.3.0 (1a2b3c4)".
std::string VersionText();

}  // namespace plslam
