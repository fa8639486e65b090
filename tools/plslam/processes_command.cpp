// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <CLI/CLI.hpp>

#include "tools/plslam/commands.h"
#include "tools/plslam/process_table.h"

namespace plslam {
namespace {

int PrintProcesses() {
  fmt::print("{:<10} {:<16} {:<12} {}\n", "name", "executable", "when it ends", "what it does");
  for (const ProcessRow& row : ProcessTable()) {
    fmt::print("{:<10} {:<16} {:<12} {}\n", row.name, row.executable,
               row.ending != Supervisor::Ending::kMayEnd ? "restarted" : "is done", row.meaning);
  }
  return 0;
}

}  // namespace

void AddProcessesCommand(CLI::App* app, Command* command) {
  auto* sub = app->add_subcommand("processes", "the table of processes that `run` starts");
  sub->callback([command] { *command = PrintProcesses; });
}

}  // namespace plslam
