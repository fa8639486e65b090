// SPDX-License-Identifier: BSD-3-Clause
#include "tools/command_line/version.h"
#include "plslam_version.h"

namespace plslam {

std::string VersionText() {
  const std::string commit = PLSLAM_COMMIT;
  return commit.empty() ? PLSLAM_VERSION : PLSLAM_VERSION " (" + commit + ")";
}

}  // namespace plslam
