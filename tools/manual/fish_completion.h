#pragma once

#include <string>
#include <vector>

#include "tools/manual/help_page.h"

namespace plslam {

/// Completion of a program for fish: options with their meanings, commands, the values of options
/// that have a list, folders and files. `pages` as for BashCompletion.
std::string FishCompletion(const std::vector<HelpPage>& pages);

}  // namespace plslam
