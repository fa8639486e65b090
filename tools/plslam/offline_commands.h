// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

namespace CLI {
class App;
}

namespace plslam::launcher {

/// Adds the commands that the program plslam_offline has (tools/offline) to the list of --help.
void ListOfflineCommands(CLI::App* app);

/// True if the first argument is one of these commands.
bool IsOfflineCommand(int argc, char** argv);

/// Replaces this process by plslam_offline, with the same arguments. Returns only if that program cannot be started:
/// the exit code 1, after a sentence on standard error.
int RunOfflineCommand(char** argv);

/// Runs a command of plslam_offline, to which alone SIGINT means something meanwhile, and returns its exit code. Throws
/// std::runtime_error if it cannot be started.
int WaitForOfflineCommand(std::vector<std::string> arguments);

/// Throws std::runtime_error if plslam_offline is not beside this program.
void CheckOfflineCommands();

}  // namespace plslam::launcher
