// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>

namespace CLI {
class App;
}

namespace plslam::doctor {

/// Adds the subcommand `doctor`, which, when chosen, sets `*command` to the function that returns the exit code.
void AddDoctorCommand(CLI::App* app, std::function<int()>* command);

}  // namespace plslam::doctor
