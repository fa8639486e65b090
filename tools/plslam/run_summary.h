// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "core/run/run_warnings.h"
#include "tools/plslam/run_statistics.h"
#include "tools/plslam/supervisor.h"

namespace plslam::launcher {

/// Sums over all processes of a run.
struct MessageCounts {
  int64_t lost = 0;
  int64_t repaired = 0;
  int64_t rejected = 0;
};

/// Everything a run leaves behind in `summary.json`, but the trajectories.
struct RunSummary {
  std::string dataset;
  std::string version;
  /// False where the run was stopped or failed; then `reason` says why.
  bool completed = false;
  std::string reason;
  double wall_s = 0.0;
  FrameTally frames;
  /// What the processes have said of the data.
  RunCounters counters;
  const RunStatistics* statistics = nullptr;
  const MapStatistics* map = nullptr;
  const LoopStatistics* loops = nullptr;
  /// Of the final trajectory; and the error of the poses as they were published.
  std::optional<nlohmann::json> accuracy;
  std::optional<double> live_ate_m;
  /// Length of the final trajectory.
  std::optional<double> path_m;
  MessageCounts messages;
  /// Files of the recording: more than one where the recorder was started again. Empty: none was asked for.
  std::vector<std::string> recordings;
  std::vector<ProcessReport> processes;
  /// Effective configuration (YAML) by process.
  std::map<std::string, std::string> configurations;
};

/// What of the summary is looked at for warnings.
RunFindings FindingsOf(const RunSummary& summary);

nlohmann::json SummaryToJson(const RunSummary& summary);

/// For people: a dozen lines at most. `verbose`: also what the map is made of, all errors, and tables of times and
/// processes.
std::string SummaryToText(const nlohmann::json& summary, bool verbose = false);

}  // namespace plslam::launcher
