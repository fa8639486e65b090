#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "tools/plslam/run_options.h"
#include "tools/plslam/supervisor.h"

namespace plslam {

/// A process of the system: one row of the table that `plslam run` starts and `plslam processes` prints.
struct ProcessRow {
  std::string_view name;        ///< of the log file and in the summary
  std::string_view executable;  ///< in the folder of `plslam` itself
  std::string_view meaning;
  Supervisor::Ending ending;
  /// Started when all others are ready.
  bool starts_last;
  bool (*wanted)(const RunOptions&);
  /// Arguments of its own; those that all processes share come from CommonArguments.
  std::vector<std::string> (*arguments)(const RunOptions&);
};

/// In the order of starting.
std::span<const ProcessRow> ProcessTable();

/// Configuration, bus and parent, as RunProcess (core/bus/process.h) takes them.
std::vector<std::string> CommonArguments(const RunOptions& options);

}  // namespace plslam
