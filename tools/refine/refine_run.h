// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>

#include <nlohmann/json.hpp>

#include "tools/refine/refine_map.h"

namespace plslam::refine {

struct RefineRequest {
  /// A map file, or the folder of a run that contains one.
  std::string source;
  /// Folder to write to.
  std::string out;
  RefineOptions options;
};

/// Absolute trajectory errors against the ground truth of the run, rmse after alignment by SE(3).
struct RefineErrors {
  double before_m = 0.0;
  double after_m = 0.0;
};

struct RefinedRun {
  RefineReport report;
  std::optional<RefineErrors> errors;
  /// The table of before and after, for a terminal.
  std::string table;
};

/// Refines a map or a run and writes the folder `out`: map.plmap, trajectory.tum, keyframes.tum, camera.yaml and
/// summary.json, and copies of the run's groundtruth.tum and of its report.html, with the table of before and after. The
/// source is not changed. Throws std::runtime_error with one
/// sentence if the source has no map, the map cannot be refined, or `out` is the source or cannot be written.
RefinedRun RefineRun(const RefineRequest& request);

}  // namespace plslam::refine
