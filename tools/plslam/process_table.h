// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "tools/launch/supervisor.h"
#include "tools/plslam/run_options.h"

namespace plslam::launcher {

/// Niceness of a process, relevant with few processors (`ChildProcess`).
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

/// File in which "vo", "mapping" or "dense" keeps the state to restore after a crash, of this run only.
std::filesystem::path StateFileOf(const RunOptions& options, const std::string& process);

/// Returns its name for sentences: "mapping_process", but not "plslam" for the recorder.
std::string_view TitleOf(const ProcessRow& row);

/// Returns the name of the process that sends frames.
const char* SourceOfFrames(const RunOptions& options);

/// Returns the niceness for the pace of this run.
int NicenessOf(const ProcessRow& row, const RunOptions& options);

/// The processes in starting order.
std::span<const ProcessRow> ProcessTable();

/// Returns the file of the recorder: FILE, and FILE.2, FILE.3, ... after restarts, since a log that is opened again is
/// emptied.
std::filesystem::path RecordingOf(const RunOptions& options, int restart);

/// Returns configuration, bus and parent as RunProcess (core/process/process.h) takes them, then the process's own
/// arguments, so that an option of `plslam run` overrides `--set`.
std::vector<std::string> ArgumentsOf(const ProcessRow& row, const RunOptions& options);

struct Restart {
  std::string name;
  int number = 1;  ///< so many times it has been started again
  /// Number and time of the newest frame that has a pose; -1: none.
  std::pair<FrameId, int64_t> newest_frame{-1, 0};
  bool paused = false;  ///< the player was
};

/// Returns the arguments of a restart, from those of the first start: the sender of frames gets the resume point, the
/// recorder another file.
std::vector<std::string> ArgumentsOfRestart(const RunOptions& options, const Restart& restart,
                                            std::vector<std::string> arguments);

}  // namespace plslam::launcher
