// SPDX-License-Identifier: BSD-3-Clause
#include "tools/plslam/offline_commands.h"

#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <string>
#include <string_view>

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include "core/errors/standard_streams.h"
#include "core/io/files/shared_file.h"

namespace plslam::launcher {
namespace {

struct OfflineCommand {
  const char* name;
  const char* description;  ///< as plslam_offline itself prints it
};

constexpr OfflineCommand kOfflineCommands[] = {
    {"export", "exports a saved map, a run or a recorded log to files for other programs"},
    {"refine", "adjusts a saved map as a whole: the best map that its features allow"},
    {"doctor", "finds what is wrong on this host, with the commands that repair it"},
    {"rectify-check", "measures and draws how well a stereo calibration aligns rows"},
    {"calibration", "reads the stereo calibration of another program into a camera.yaml"},
    {"calibrate", "calibrates a stereo camera from pictures of a board"},
};

}  // namespace

void ListOfflineCommands(CLI::App* app) {
  for (const OfflineCommand& command : kOfflineCommands) app->add_subcommand(command.name, command.description);
}

bool IsOfflineCommand(int argc, char** argv) {
  return argc > 1 && std::ranges::any_of(kOfflineCommands, [&](const OfflineCommand& command) {
           return std::string_view(argv[1]) == command.name;
         });
}

int RunOfflineCommand(char** argv) {
  const std::string program = ProgramFolder() / "plslam_offline";
  execv(program.c_str(), argv);
  PrintError(fmt::format("plslam: error: {} cannot be started ({}): 'scripts/build release' builds all programs",
                         program, std::strerror(errno)));
  return 1;
}

}  // namespace plslam::launcher
