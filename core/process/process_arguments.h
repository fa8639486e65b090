// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/config/config.h"

namespace CLI {
class App;
}

namespace plslam::bus {

/// What the command line of every process has.
struct ProcessArguments {
  std::string config_file;
  std::vector<std::string> overrides;
  std::optional<std::string> url;
  std::optional<std::string> prefix;
  std::optional<std::string> map_prefix;
  int parent = 0;

  void AddTo(CLI::App* app);

  /// File, overrides, URL and prefix in one. Throws ConfigError.
  Config MakeConfig() const;
  /// Makes the kernel end this process (SIGTERM) with the one that started it (`--parent`). Throws std::runtime_error
  /// where that one has gone already.
  void EndWithParent() const;
};

/// Log lines go to stderr, one each; stdout is for results.
void SetUpLogging(const std::string& process);

/// A line on standard error. Where that is a file on a full disk the line is lost, and nothing more: fmt::print would
/// throw.
void PrintError(const std::string& line);

/// What an exception says, on one line.
std::string OneLine(std::string text);

}  // namespace plslam::bus
