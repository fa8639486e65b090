// SPDX-License-Identifier: BSD-3-Clause
#include "tools/command_line/run_command_line.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <exception>

#include "core/config/command_line_error.h"
#include "core/errors/error_text.h"
#include "core/errors/standard_streams.h"

namespace plslam {

int RunCommandLine(CLI::App& app, int argc, char** argv, const std::function<int()>& work) {
  IgnoreFileSizeSignal();
  try {
    app.parse(argc, argv);
    return FlushOutput(app.get_name(), work());
  } catch (const CLI::ParseError& e) {
    if (e.get_exit_code() == 0) return FlushOutput(app.get_name(), app.exit(e));
    PrintError(fmt::format("{}: error: {}", app.get_name(), CommandLineError(app, e, argc, argv)));
  } catch (const std::exception& e) {
    PrintError(fmt::format("{}: error: {}", app.get_name(), SentenceOf(e)));
  }
  return 1;
}

}  // namespace plslam
