// SPDX-License-Identifier: BSD-3-Clause
#include "tools/plslam/offline_commands.h"

#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <stdexcept>
#include <string>
#include <string_view>

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include "core/errors/standard_streams.h"
#include "core/files/shared_file.h"
#include "core/process/argument_vector.h"

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

std::string OfflineProgram() { return ProgramFolder() / "plslam_offline"; }

std::string CannotBeStarted(int error) {
  return fmt::format("{} cannot be started ({}): 'scripts/build release' builds all programs", OfflineProgram(),
                     std::strerror(error));
}

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
  execv(OfflineProgram().c_str(), argv);
  PrintError(fmt::format("plslam: error: {}", CannotBeStarted(errno)));
  return 1;
}

int WaitForOfflineCommand(std::vector<std::string> arguments) {
  const std::string program = OfflineProgram();
  arguments.insert(arguments.begin(), "plslam");
  const std::vector<char*> words = ArgumentVector(arguments);
  posix_spawnattr_t attributes;
  posix_spawnattr_init(&attributes);
  sigset_t interrupt;
  sigemptyset(&interrupt);
  sigaddset(&interrupt, SIGINT);
  posix_spawnattr_setsigdefault(&attributes, &interrupt);
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSIGDEF);
  const auto before = signal(SIGINT, SIG_IGN);
  pid_t pid = -1;
  const int error = posix_spawn(&pid, program.c_str(), nullptr, &attributes, words.data(), environ);
  posix_spawnattr_destroy(&attributes);
  int status = 0;
  while (error == 0 && waitpid(pid, &status, 0) < 0 && errno == EINTR) {
  }
  signal(SIGINT, before);
  if (error != 0) throw std::runtime_error(CannotBeStarted(error));
  return WIFEXITED(status) ? WEXITSTATUS(status) : 1;
}

void CheckOfflineCommands() {
  if (access(OfflineProgram().c_str(), X_OK) != 0) throw std::runtime_error(CannotBeStarted(errno));
}

}  // namespace plslam::launcher
