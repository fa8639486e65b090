// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include "core/geometry/se3.h"
#include "core/io/trajectories/trajectory.h"
#include "tools/evaluate/run_record.h"

namespace plslam::evaluate {

/// The files that a run has written about where its camera was. The body is the left camera as calibrated.
struct RunPaths {
  Trajectory estimate;           ///< in w, the map of the run; not empty
  Trajectory truth;              ///< empty if it is unknown
  std::optional<SE3> T_truth_w;  ///< alignment of both, if there is truth
};

/// Returns nullopt if the trajectory is missing, empty or unreadable.
std::optional<RunPaths> ReadRunPaths(const RunRecord& run);

/// Returns the transform from the map of `other` to that of `base`: through the truth if both have it, else by their
/// own paths, else as if both had begun at one position.
SE3 BaseFromOther(const RunPaths& base, const RunPaths& other);

}  // namespace plslam::evaluate
