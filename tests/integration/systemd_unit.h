// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace plslam::test {

/// Settings of a service unit that decide which processes run, with which arguments and environment, and where.
struct SystemdUnit {
  struct Command {
    std::vector<std::string> words;
    bool may_fail = false;  ///< prefix "-"
  };
  std::vector<Command> start_pre;
  Command start;
  std::vector<std::string> environment;  ///< NAME=VALUE
  std::string state_directory;           ///< relative to /var/lib
  std::string runtime_directory;         ///< relative to /run
  std::string working_directory;
  int nice = 0;
};

/// Folders that stand for those of the machine.
struct SystemdFolders {
  std::filesystem::path etc;
  std::filesystem::path state;    ///< %S
  std::filesystem::path runtime;  ///< %t
};

/// Reads PROGRAM@.service as systemd does for PROGRAM@INSTANCE.service: words are split first, then specifiers are
/// replaced. A word that begins with /etc/ is moved into `folders.etc`. Throws std::runtime_error that names the file
/// if it cannot be read, has no ExecStart, or has a specifier or a prefix of a command that is unknown here.
SystemdUnit ReadSystemdUnit(const std::filesystem::path& file, const std::string& instance,
                            const SystemdFolders& folders);

}  // namespace plslam::test
