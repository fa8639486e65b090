// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

namespace plslam::manual {

/// An option, argument or command as `--help` shows it.
struct HelpEntry {
  std::vector<std::string> names;    ///< "-h", "--help"; of an argument or command: its name
  std::string value;                 ///< text after the names ("TEXT:{a,b} REQUIRED"); empty for flags
  std::vector<std::string> choices;  ///< the only values, if there is such a list
  std::string meaning;

  bool TakesValue() const { return !value.empty(); }
};

/// One `--help` of a program that uses CLI11.
struct HelpPage {
  std::string command;  ///< "plslam run"
  std::string purpose;
  std::string usage;  ///< text after the name of the command
  std::vector<HelpEntry> arguments;
  std::vector<HelpEntry> options;
  std::vector<HelpEntry> commands;
  std::string footer;

  /// The first line of the purpose.
  std::string Summary() const { return purpose.substr(0, purpose.find('\n')); }

  /// Commands, and words that the footer names as such ("`evaluate places DATASET...`").
  std::vector<std::string> CommandNames() const;
};

/// Parses the output of `command --help`. Throws std::runtime_error with the line that cannot be parsed: the manual
/// would otherwise be incomplete.
HelpPage ParseHelp(const std::string& command, const std::string& text);

}  // namespace plslam::manual
