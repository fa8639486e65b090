// SPDX-License-Identifier: BSD-3-Clause
#include <CLI/CLI.hpp>
#include <string_view>

#include "core/process/process_arguments.h"
#include "tools/command_line/run_command_line.h"
#include "tools/command_line/version.h"
#include "tools/plslam/commands.h"
#include "tools/plslam/offline_commands.h"

namespace {

constexpr std::string_view kHelp = "help";

/// `plslam help COMMAND` means `plslam COMMAND --help`, and `plslam help` means `plslam --help`.
void HelpIsAnOption(int argc, char** argv) {
  static char option[] = "--help";
  if (argc < 2 || argc > 3 || std::string_view(argv[1]) != kHelp) return;
  if (argc == 3) argv[1] = argv[2];
  argv[argc - 1] = option;
}

}  // namespace

int main(int argc, char** argv) {
  HelpIsAnOption(argc, argv);
  if (plslam::launcher::IsOfflineCommand(argc, argv)) return plslam::launcher::RunOfflineCommand(argv);
  CLI::App app("Runs, records and replays stereo visual SLAM with points and lines.", "plslam");
  app.set_version_flag("--version", plslam::VersionText());
  app.require_subcommand(1);
  app.footer(
      "Examples:\n"
      "  plslam run synthetic:room --out out/room\n"
      "  plslam run /data/kitti/03 --out out/kitti_03 --features points\n"
      "  plslam run /data/euroc/MH_01 --out out/mh01 --pace realtime --record out/mh01.lcm\n"
      "  plslam replay out/mh01.lcm --out out/mh01_again\n"
      "  plslam export out/mh01.plmap --format ply colmap\n"
      "  plslam doctor\n"
      "plslam COMMAND --help lists the options of each. Exit code 0: done; 1: failed, with one sentence on standard "
      "error; 2, with --strict: a run that is done, with warnings.");
  plslam::launcher::Command command;
  for (const auto add :
       {plslam::launcher::AddRunCommand, plslam::launcher::AddReplayCommand, plslam::launcher::AddRecordCommand,
        plslam::launcher::AddOrderCommands, plslam::launcher::AddTopCommand, plslam::launcher::AddRelayCommand,
        plslam::launcher::AddBridgeCommand, plslam::launcher::AddTopicsCommand, plslam::launcher::AddProcessesCommand,
        plslam::launcher::AddConfigCommand}) {
    add(&app, &command);
  }
  plslam::launcher::ListOfflineCommands(&app);
  // Log lines are kept apart from the output of a command.
  plslam::bus::SetUpLogging("plslam");
  return plslam::RunCommandLine(app, argc, argv, [&] { return command(); });
}
