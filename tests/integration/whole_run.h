// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "tools/launch/child_process.h"

namespace plslam::test {

/// Runs the real `plslam` with the other real executables, in a separate folder, on a private port of this machine.
/// Under a sanitizer all limits are longer (Patience), and a report of a sanitizer in any process fails the test.
class WholeRun {
 public:
  WholeRun();
  ~WholeRun();
  WholeRun(const WholeRun&) = delete;
  WholeRun& operator=(const WholeRun&) = delete;

  /// Starts `plslam ARGUMENTS...`, with `--out OUT` if the command has outputs.
  void Start(std::vector<std::string> arguments);
  /// Returns the exit code; -1 (and killed) if it has not exited within `limit_s`.
  int Wait(int limit_s = 240);
  int Run(std::vector<std::string> arguments);

  /// Polls until `done`, at most a minute.
  static bool WaitFor(const std::function<bool()>& done);

  const std::filesystem::path& folder() const { return folder_; }
  std::filesystem::path out() const { return folder_ / "out"; }
  /// File of the recording.
  std::string log() const { return (folder_ / "run.lcm").string(); }
  nlohmann::json Summary() const;
  std::string Read(const std::string& file_of_out) const;
  /// Logs of all processes, for messages of failed tests.
  std::string Logs() const;
  const launcher::ChildProcess& process() const { return *process_; }
  bool ended() const { return process_->Poll().has_value(); }
  /// Returns the process id of a running executable that this run started; -1 if there is none.
  pid_t PidOf(const std::string& executable) const;
  /// Signals the running executable that this run started; false if there is none.
  bool Signal(const std::string& executable, int signal) const;
  /// Ids of `plslam` itself and of its running child processes.
  std::vector<pid_t> Pids() const;
  /// Returns whether no process with one of these ids runs any more, except for zombies.
  static bool Ended(const std::vector<pid_t>& pids);

 private:
  std::filesystem::path folder_;
  std::unique_ptr<launcher::ChildProcess> process_;
};

/// Runs `command` on a separate file system of so many KiB; `command` is a line for sh, and `folder` is the mount
/// point. Its content is lost afterwards: the command must copy the files to check. Output goes to `folder`.sh.log.
/// Returns the exit code; nullopt if this machine does not allow it.
std::optional<int> OnASmallDisk(const std::filesystem::path& folder, int kib, const std::string& command);

}  // namespace plslam::test
