// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "tools/manual/help_page.h"

namespace plslam::manual {

// Completion of a program for each shell: options, commands, the values of options that have a list, folders and
// files; for zsh and fish with the meanings of options. `pages[0]` is the program's own help, the others those of its
// commands.

std::string BashCompletion(const std::vector<HelpPage>& pages);
std::string ZshCompletion(const std::vector<HelpPage>& pages);
std::string FishCompletion(const std::vector<HelpPage>& pages);

}  // namespace plslam::manual
