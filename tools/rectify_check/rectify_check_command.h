// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>

namespace CLI {
class App;
}

namespace plslam::rectify_check {

/// Adds the subcommand `rectify-check`, which, when chosen, sets `*command` to the function that returns the exit code.
void AddRectifyCheckCommand(CLI::App* app, std::function<int()>* command);

}  // namespace plslam::rectify_check
