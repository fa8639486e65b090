// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/run/frame_tally.h"
#include "core/run/run_counters.h"

namespace plslam {

/// What a run has shown of itself and of its data, as far as it is known: what is looked at for warnings.
struct RunFindings {
  std::string dataset;
  FrameTally frames;
  /// See run_counters.h.
  double points_seen = 0.0;
  double points_matched = 0.0;
  double dark_frames = 0.0;
  double corner_rows_px = 0.0;
  double right_late_ms = 0.0;
  double left_late_ms = 0.0;
  double late_frames = 0.0;
  double unequal_readout_ms = 0.0;
  double points_ambiguous = 0.0;
  double disparity_error_px = 0.0;
  double disparity_sigma_px = 0.0;
  double length_error_percent = 0.0;
  double truth_frames = 0.0;
  double truth_missing = 0.0;
  double pictures_missing = 0.0;
  double recording_scan_s = 0.0;
  /// Of live cameras. Images of either camera without a partner are `frames_dropped`.
  double frames_captured = 0.0;
  double skew_ms = 0.0;
  double frames_missing = 0.0;
  double frames_dropped = 0.0;
  double frames_overexposed = 0.0;
  double frames_underexposed = 0.0;
  double outages = 0.0;
  /// Root mean square of the errors of position after alignment; and of the distances of the true positions from
  /// their mean.
  std::optional<double> ate_m;
  double true_spread_m = 0.0;
  /// Mean NEES of the poses (6 is expected), and of how many.
  double nees_pose = 0.0;
  int64_t nees_poses = 0;
  /// Files of the recording: more than one where the recorder was started again.
  std::vector<std::string> recordings;

  void Take(const RunCounters& counters);
};

/// Something that the user of a finished run should know.
struct RunWarning {
  std::string code;      ///< for programs: "little_tracked"
  std::string sentence;  ///< what was found, what it may mean, what helps
  std::vector<std::pair<std::string, double>> numbers;
};

/// As summary.json and the report have it: `code`, `sentence`, `numbers` by name.
nlohmann::ordered_json ToJson(const RunWarning& warning);

/// One for each row of the table whose condition holds, in its order. docs/metrics.md has the table for users.
std::vector<RunWarning> WarningsOf(const RunFindings& findings);

/// Those of live cameras, which are told while a run goes on, too.
std::vector<RunWarning> CameraWarningsOf(const RunFindings& findings);

/// All codes there are, in the order of the table.
std::vector<std::string> WarningCodes();

}  // namespace plslam
