// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>

namespace CLI {
class App;
}

namespace plslam::launcher {

/// The command chosen on the command line; its result is the exit code.
using Command = std::function<int()>;

// Each adds a subcommand with its options, which, when chosen, sets `*command`. All data that `*command` refers to live
// as long as it does.
void AddRunCommand(CLI::App* app, Command* command);
void AddReplayCommand(CLI::App* app, Command* command);
void AddRecordCommand(CLI::App* app, Command* command);
/// Adds the orders to processes that run: save, load, reset, localise, pause and resume.
void AddOrderCommands(CLI::App* app, Command* command);
void AddTopCommand(CLI::App* app, Command* command);
void AddRelayCommand(CLI::App* app, Command* command);
/// Serves Foxglove, by the program plslam_bridge.
void AddBridgeCommand(CLI::App* app, Command* command);
/// Lists topics of ROS 2, by the program plslam_ros2.
void AddTopicsCommand(CLI::App* app, Command* command);
void AddProcessesCommand(CLI::App* app, Command* command);
void AddConfigCommand(CLI::App* app, Command* command);

}  // namespace plslam::launcher
