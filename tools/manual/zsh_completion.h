#pragma once

#include <string>
#include <vector>

#include "tools/manual/help_page.h"

namespace plslam {

/// Completion of a program for zsh, as its `_arguments` wants it: options with their meanings, commands, the values of options
/// that have a list, folders and files. `pages` as for BashCompletion.
std::string ZshCompletion(const std::vector<HelpPage>& pages);

}  // namespace plslam
