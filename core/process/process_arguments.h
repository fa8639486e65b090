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

/// The command-line arguments that all processes have in common.
struct ProcessArguments {
  std::string config_file;
  std::vector<std::string> overrides;
  std::optional<std::string> url;
  std::optional<std::string> prefix;
  std::optional<std::string> map_prefix;
  int parent = 0;
  bool own_bus = false;

  void AddTo(CLI::App* app);

  /// File, overrides, URL and prefix in one. Throws ConfigError.
  Config MakeConfig() const;
  /// Makes the kernel end this process (SIGTERM) with the one that started it (`--parent`). Throws std::runtime_error
  /// if the parent has already exited.
  void EndWithParent() const;
};

/// Exit code of a process with a parent that has found another process of its name on the bus: the parent need not
/// start it again.
inline constexpr int kExitCodeOfNamesake = 4;

/// Log lines go to stderr, one each; stdout is for results.
void SetUpLogging(const std::string& process);

/// Returns the text of an exception on one line.
std::string OneLine(std::string text);

}  // namespace plslam::bus
