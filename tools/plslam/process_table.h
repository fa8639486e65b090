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

namespace plslam {

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
  /// Arguments of its own; those that all processes share come from CommonArguments.
  std::vector<std::string> (*arguments)(const RunOptions&);
};

/// Where "vo" or "mapping" keeps what it needs after a crash; of this run only.
std::filesystem::path StateFileOf(const RunOptions& options, const std::string& process);

/// Of the pace that `plslam run` was asked for.
int NicenessOf(const ProcessRow& row, const RunOptions& options);

/// In the order of starting.
std::span<const ProcessRow> ProcessTable();

/// What a process is told beside its arguments when it is started again: the player, where to go on. `newest_frame`: number
/// and time of the newest frame that has a pose; -1: none.
std::vector<std::string> ArgumentsOfRestart(const std::string& name, std::pair<int64_t, int64_t> newest_frame);

/// Configuration, bus and parent, as RunProcess (core/bus/process.h) takes them.
std::vector<std::string> CommonArguments(const RunOptions& options);

}  // namespace plslam
