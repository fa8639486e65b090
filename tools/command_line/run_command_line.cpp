// SPDX-License-Identifier: BSD-3-Clause
#include "tools/command_line/run_command_line.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <exception>
#include <string>
#include <vector>

#include "core/config/nearest_key.h"
#include "core/errors/error_text.h"
#include "core/errors/standard_streams.h"

namespace plslam {
namespace {

/// Wrong letters in a mistyped name; one with more was meant otherwise.
constexpr int kTypo = 2;

/// Returns a sentence if the first argument is none of the commands; empty otherwise.
std::string UnknownCommand(const CLI::App& app, int argc, char** argv) {
  if (argc < 2 || argv[1][0] == '-') return "";
  std::vector<std::string> names;
  for (const CLI::App* command : app.get_subcommands({})) names.push_back(command->get_name());
  if (names.empty() || std::ranges::find(names, argv[1]) != names.end()) return "";
  const std::string nearest = NearestKey(argv[1], names);
  const bool is_typo = EditDistance(argv[1], nearest) <= kTypo;
  return fmt::format("there is no command '{}'{} (--help lists all)", Shown(argv[1]),
                     is_typo ? fmt::format("; the nearest is '{}'", nearest) : "");
}

}  // namespace

int RunCommandLine(CLI::App& app, int argc, char** argv, const std::function<int()>& work) {
  IgnoreFileSizeSignal();
  try {
    app.parse(argc, argv);
    return FlushOutput(app.get_name(), work());
  } catch (const CLI::ParseError& e) {
    if (e.get_exit_code() == 0) return FlushOutput(app.get_name(), app.exit(e));
    const std::string unknown = UnknownCommand(app, argc, argv);
    PrintError(fmt::format("{}: error: {}", app.get_name(),
                           unknown.empty() ? fmt::format("{} (--help lists the options)", e.what()) : unknown));
  } catch (const std::exception& e) {
    PrintError(fmt::format("{}: error: {}", app.get_name(), SentenceOf(e)));
  }
  return 1;
}

}  // namespace plslam
