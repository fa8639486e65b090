// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "core/run/run_warnings.h"
#include "tools/launch/supervisor.h"
#include "tools/plslam/run_statistics.h"

namespace plslam::launcher {

/// Sums over all processes of a run.
struct MessageCounts {
  int64_t lost = 0;
  int64_t repaired = 0;
  int64_t rejected = 0;
};

/// Reason of a run that the user ended, with all its results.
inline constexpr const char* kInterrupted = "interrupted";

/// The content of `summary.json`.
struct RunSummary {
  std::string dataset;
  /// Map that the run has continued; empty: none.
  std::string map_file;
  std::string version;
  /// False if the run was stopped or failed; `reason` is then set.
  bool completed = false;
  std::string reason;
  double wall_s = 0.0;
  FrameTally frames;
  /// Counters of the processes about the data.
  RunCounters counters;
  /// Published by the processes.
  std::vector<RunWarning> warnings;
  const RunStatistics* statistics = nullptr;
  const MapStatistics* map = nullptr;
  const LoopStatistics* loops = nullptr;
  /// Accuracy of the final trajectory; and the error of the poses as published.
  std::optional<nlohmann::json> accuracy;
  std::optional<double> live_ate_m;
  /// Length of the final trajectory.
  std::optional<double> path_m;
  MessageCounts messages;
  /// Files of the recording: more than one if the recorder was restarted. Empty: no recording was requested.
  std::vector<std::string> recordings;
  std::vector<ProcessReport> processes;
  /// Effective configuration (YAML) by process.
  std::map<std::string, std::string> configurations;
};

/// Returns the part of the summary from which warnings are derived.
RunFindings FindingsOf(const RunSummary& summary);

nlohmann::json SummaryToJson(const RunSummary& summary);

/// Text for users: a dozen lines at most. `verbose`: also the composition of the map, all errors, and tables of times
/// and processes.
std::string SummaryToText(const nlohmann::json& summary, bool verbose = false);

}  // namespace plslam::launcher
