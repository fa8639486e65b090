#pragma once

#include <string>
#include <vector>

#include "tools/manual/help_page.h"

namespace plslam {

/// Completion of a program for bash: options, commands, the values of options that have a list, folders and files.
/// `pages[0]` is the program's own help, the others those of its commands.
std::string BashCompletion(const std::vector<HelpPage>& pages);

}  // namespace plslam
