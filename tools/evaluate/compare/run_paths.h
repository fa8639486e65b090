// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>

#include "core/geometry/se3.h"
#include "core/run/run.h"

namespace plslam::evaluate {

/// Reads the trajectory of a run, and the truth. Returns nullopt if the trajectory is missing, empty or unreadable; an
/// unreadable truth counts as none.
std::optional<Run> FindRunPaths(const std::string& folder);

/// Returns the alignment of the trajectory with the truth; nullopt if they have no moment in common.
std::optional<SE3> TruthFromMap(const Run& run);

/// Returns the transform from the map of `other` to that of `base`: through the truth if both have it, else by their
/// own paths, else as if both had begun at one position. Both have a trajectory.
SE3 BaseFromOther(const Run& base, const Run& other);

}  // namespace plslam::evaluate
