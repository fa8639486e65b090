// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "tools/plslam/child_process.h"

namespace plslam::test {

/// Runs the real `plslam` with the other real executables, in a folder of its own, on a private port of this machine.
/// Under a sanitizer all limits are longer (Patience), and what it finds in a process fails the test.
class WholeRun {
 public:
  WholeRun();
  ~WholeRun();
  WholeRun(const WholeRun&) = delete;
  WholeRun& operator=(const WholeRun&) = delete;

  /// `plslam ARGUMENTS...`, and `--out OUT` where that makes sense.
  void Start(std::vector<std::string> arguments);
  /// Exit code; -1 (and killed) where it has not ended within `limit_s`.
  int Wait(int limit_s = 240);
  int Run(std::vector<std::string> arguments);

  /// Polls until `done`, at most a minute.
  static bool WaitFor(const std::function<bool()>& done);

  const std::filesystem::path& folder() const { return folder_; }
  std::filesystem::path out() const { return folder_ / "out"; }
  /// Where to record to.
  std::string log() const { return (folder_ / "run.lcm").string(); }
  nlohmann::json Summary() const;
  std::string Read(const std::string& file_of_out) const;
  /// Logs of all processes, for messages of failed tests.
  std::string Logs() const;
  const launcher::ChildProcess& process() const { return *process_; }
  bool ended() const { return process_->Poll().has_value(); }
  /// Process id of a running executable that this run started; -1 where there is none.
  pid_t PidOf(const std::string& executable) const;
  /// Of `plslam` itself and all processes that it has started and that run.
  std::vector<pid_t> Pids() const;

 private:
  std::filesystem::path folder_;
  std::unique_ptr<launcher::ChildProcess> process_;
};

/// Runs `command` on a file system of its own of so many KiB; `command` is a line for sh, and `folder` is where the
/// file system is mounted. What is on it is gone afterwards: the command copies out what is looked at. Output goes to
/// `folder`.sh.log. Exit code; nullopt where this machine does not allow it.
std::optional<int> OnASmallDisk(const std::filesystem::path& folder, int kib, const std::string& command);

}  // namespace plslam::test
