// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "tools/plslam/run_options.h"
#include "tools/plslam/supervisor.h"

namespace plslam::launcher {

/// How far a process stands back where processors are few (`ChildProcess`).
struct Niceness {
  int lockstep = 0;
  int live = 0;
};

/// A process of the system: one row of the table that `plslam run` starts and `plslam processes` prints.
struct ProcessRow {
  std::string_view name;        ///< of the log file and in the summary
  std::string_view executable;  ///< in the folder of `plslam` itself
  std::string_view meaning;
  Supervisor::Ending ending;
  /// Started when all others are ready.
  bool starts_last;
  bool (*wanted)(const RunOptions&);
  Niceness niceness;
  /// Its own; ArgumentsOf has all.
  std::vector<std::string> (*arguments)(const RunOptions&);
};

/// Where "vo" or "mapping" keeps what it needs after a crash; of this run only.
std::filesystem::path StateFileOf(const RunOptions& options, const std::string& process);

/// Its name in sentences: "mapping_process", but not "plslam" for the recorder.
std::string_view TitleOf(const ProcessRow& row);

/// The name of the process that sends frames.
const char* SourceOfFrames(const RunOptions& options);

/// Of the pace that `plslam run` was asked for.
int NicenessOf(const ProcessRow& row, const RunOptions& options);

/// In the order of starting.
std::span<const ProcessRow> ProcessTable();

/// Where the recorder writes: FILE, and FILE.2, FILE.3, ... where it had to be started again, since a log that is
/// opened anew is empty.
std::filesystem::path RecordingOf(const RunOptions& options, int restart);

/// Configuration, bus and parent, as RunProcess (core/process/process.h) takes them; then its own, so that an option
/// of `plslam run` wins over `--set`.
std::vector<std::string> ArgumentsOf(const ProcessRow& row, const RunOptions& options);

struct Restart {
  std::string name;
  int number = 1;  ///< so many times it has been started again
  /// Number and time of the newest frame that has a pose; -1: none.
  std::pair<int64_t, int64_t> newest_frame{-1, 0};
  bool paused = false;  ///< the player was
};

/// From those of its first start: who sends frames is told where to go on, the recorder another file.
std::vector<std::string> ArgumentsOfRestart(const RunOptions& options, const Restart& restart,
                                            std::vector<std::string> arguments);

}  // namespace plslam::launcher
