// SPDX-License-Identifier: BSD-3-Clause
#include "core/config/command_line_error.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <string>
#include <vector>

#include "core/config/nearest_key.h"
#include "core/errors/error_text.h"

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

/// The command on whose arguments the parser stopped: the last one that was named.
const CLI::App& NamedCommand(const CLI::App& app) {
  const std::vector<const CLI::App*> named =
      app.get_subcommands([](const CLI::App* command) { return command->count_all() > 0 || command->parsed(); });
  return named.empty() ? app : NamedCommand(*named.back());
}

/// Returns a sentence about the first argument that is neither an option of the command nor its value; empty if there is
/// none.
std::string UnknownArgument(const CLI::App& app) {
  const CLI::App& command = NamedCommand(app);
  std::vector<std::string> names;
  for (const CLI::Option* option : command.get_options()) {
    for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
  }
  for (const std::string& argument : app.remaining(true)) {
    if (!argument.starts_with('-')) return fmt::format("'{}' was not expected (--help lists all)", Shown(argument));
    if (!argument.starts_with("--") || argument.size() == 2) continue;
    const std::string option = argument.substr(0, argument.find('='));
    const std::string nearest = NearestKey(option, names);
    return fmt::format("there is no option '{}'{} (--help lists all)", Shown(option),
                       EditDistance(option, nearest) <= kTypo ? fmt::format("; the nearest is '{}'", nearest) : "");
  }
  return "";
}

}  // namespace

std::string CommandLineError(const CLI::App& app, const CLI::ParseError& error, int argc, char** argv) {
  for (std::string unknown : {UnknownCommand(app, argc, argv), UnknownArgument(app)}) {
    if (!unknown.empty()) return unknown;
  }
  return fmt::format("{} (--help lists the options)", error.what());
}

}  // namespace plslam
