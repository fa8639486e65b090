// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <sys/types.h>

#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "tests/integration/systemd_unit.h"
#include "tools/launch/child_process.h"

namespace plslam::test {

/// The units of one robot, started and stopped as systemd does: the command lines, environment, folders and niceness
/// are those of the unit files that `cmake --install` writes. /etc, /var/lib and /run are in a test's folder, and the
/// programs are those of this build. The sandbox and `Restart=` are left out.
class InstalledServices {
 public:
  /// `configuration` becomes /etc/plslam/INSTANCE.yaml. Throws std::runtime_error if the units cannot be written.
  InstalledServices(std::filesystem::path folder, std::string instance, const std::string& configuration);
  ~InstalledServices();
  InstalledServices(const InstalledServices&) = delete;
  InstalledServices& operator=(const InstalledServices&) = delete;

  /// Starts plslam-NAME@INSTANCE.service, with its `ExecStartPre`.
  void Start(const std::string& name);
  void Signal(const std::string& name, int signal) const;
  /// Waits for the end, at most `limit_s`. Returns the exit code, 128 + signal of a process that was killed, or -1.
  int ExitCode(const std::string& name, int limit_s = 60);
  bool Runs(const std::string& name);
  pid_t pid(const std::string& name) const { return processes_.at(name)->pid(); }

  /// Its StateDirectory.
  std::filesystem::path StateFolder(const std::string& name) const;
  /// Output since the newest start.
  std::string Log(const std::string& name) const;
  /// Output of all processes, for messages of failed tests.
  std::string Logs() const;

 private:
  SystemdUnit UnitOf(const std::string& name) const;
  std::filesystem::path LogFile(const std::string& name, int start) const;
  std::unique_ptr<launcher::ChildProcess> Run(const SystemdUnit& unit, const SystemdUnit::Command& command,
                                              const std::filesystem::path& log) const;

  std::filesystem::path folder_;
  std::string instance_;
  SystemdFolders folders_;
  std::map<std::string, int> starts_;
  std::map<std::string, std::unique_ptr<launcher::ChildProcess>> processes_;
};

}  // namespace plslam::test
