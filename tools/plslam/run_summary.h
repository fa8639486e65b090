#pragma once

#include <cstdint>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "tools/plslam/loop_statistics.h"
#include "tools/plslam/map_statistics.h"
#include "tools/plslam/run_statistics.h"
#include "tools/plslam/supervisor.h"

namespace plslam {

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
  int64_t bad_frames = 0;         ///< unreadable, passed over
  int64_t missing_pictures = 0;   ///< frames without the picture that report, film or overlays should have had
  int64_t unanswered_frames = 0;  ///< sent, but the tracker ended before it said anything of them
  const RunStatistics* statistics = nullptr;
  const MapStatistics* map = nullptr;
  const LoopStatistics* loops = nullptr;
  /// Of the final trajectory; and the error of the poses as they were published.
  std::optional<nlohmann::json> accuracy;
  std::optional<double> live_ate_m;
  MessageCounts messages;
  /// Files of the recording: more than one where the recorder was started again. Empty: none was asked for.
  std::vector<std::string> recordings;
  std::vector<ProcessReport> processes;
  /// Effective configuration (YAML) by process.
  std::map<std::string, std::string> configurations;
};

/// Every frame of the stream that should have got a pose: those with one, those passed over by a tracker that was too slow,
/// those that it never answered, and those that could not be read, which it never hears of.
int64_t AllFrames(const RunSummary& summary);

nlohmann::json SummaryToJson(const RunSummary& summary);

/// For people, several lines.
std::string SummaryToText(const nlohmann::json& summary);

}  // namespace plslam
