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

/// A warning for the user of a completed run.
struct RunWarning {
  std::string code;      ///< for programs: "little_tracked"
  std::string sentence;  ///< finding, possible meaning, remedy
  std::vector<std::pair<std::string, double>> numbers;
};

/// Findings about a run and its data from which the warnings are derived.
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
  double readout_ms = 0.0;
  double readout_path_mm = 0.0;
  double other_readout_ms = 0.0;
  double lens_dirt_percent = 0.0;
  double lens_dirt_u_px = 0.0;
  double lens_dirt_v_px = 0.0;
  double right_lens_dirt_percent = 0.0;
  double right_lens_dirt_u_px = 0.0;
  double right_lens_dirt_v_px = 0.0;
  double points_ambiguous = 0.0;
  double length_error_percent = 0.0;
  double length_sigma_percent = 0.0;
  double truth_frames = 0.0;
  double truth_missing = 0.0;
  double pictures_missing = 0.0;
  double recording_scan_s = 0.0;
  double frames_unanchored = 0.0;
  double unanchored_now = 0.0;
  /// Map that the run has continued; empty if there is none, or if its name is not known.
  std::string map;
  /// Frames come from a sensor, which cannot wait.
  bool is_live = false;
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
  /// Published by the processes (`warning_t`).
  std::vector<RunWarning> published;

  void Take(const RunCounters& counters);
};

/// The form in summary.json and the report: `code`, `sentence`, `numbers` by name.
nlohmann::ordered_json ToJson(const RunWarning& warning);

/// Returns the warnings whose condition holds, in the order of the table, and then the published ones. docs/metrics.md
/// has the table for users.
std::vector<RunWarning> WarningsOf(const RunFindings& findings);

/// Returns the warnings about live cameras, which are also published during a run.
std::vector<RunWarning> CameraWarningsOf(const RunFindings& findings);

/// Returns all codes, in the order of the table.
std::vector<std::string> WarningCodes();

}  // namespace plslam
