// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "tools/manual/help_page.h"

namespace plslam::manual {

/// Manual page (section 1, troff -man) of a program: `pages[0]` is its own help, the others those of its commands.
/// `programs`: all programs, for SEE ALSO.
std::string ManualPage(const std::vector<HelpPage>& pages, const std::string& version,
                       const std::vector<std::string>& programs);

}  // namespace plslam::manual
