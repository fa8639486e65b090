// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>

namespace CLI {
class App;
}

namespace plslam::exports {

/// Adds the subcommand `export`, which, when chosen, sets `*command` to the function that returns the exit code.
void AddExportCommand(CLI::App* app, std::function<int()>* command);

}  // namespace plslam::exports
