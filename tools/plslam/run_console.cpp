// SPDX-License-Identifier: BSD-3-Clause
#include "tools/plslam/run_console.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "tools/plslam/process_table.h"

namespace plslam::launcher {

RunConsole::RunConsole(const RunOptions& options)
    : quiet_(options.quiet), max_restarts_(options.max_restarts), line_(!options.quiet && !options.json) {}

void RunConsole::PrintNew(const std::vector<RunWarning>& warnings) {
  for (; n_warnings_ < warnings.size(); ++n_warnings_) {
    line_.PrintSentence("warning: " + warnings[n_warnings_].sentence);
  }
}

void RunConsole::PrintAwaited(const std::string& reason) {
  if (quiet_ || reason.empty() || reason == std::exchange(awaited_, reason)) return;
  line_.PrintSentence("no frames yet: " + reason);
}

void RunConsole::PrintStop(const std::string& what) {
  if (!quiet_) line_.PrintSentence(what + " (Ctrl-C again ends it at once)");
}

void RunConsole::PrintRestart(const std::string& process, const std::string& how, int restart) {
  const auto rows = ProcessTable();
  const auto row = std::ranges::find(rows, process, &ProcessRow::name);
  line_.PrintSentence(
      fmt::format("warning: {} {} and is started again ({} of {})", TitleOf(*row), how, restart, max_restarts_));
}

}  // namespace plslam::launcher
