// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>

#include "core/map/occupancy_grid.h"

namespace plslam::exports {

/// Reads the occupancy grid that dense_process has written to the folder of a run: map.pgm, map.yaml and frames.json;
/// nullopt if there is no map.yaml. Throws std::runtime_error with the file and its fault.
std::optional<OccupancyGrid> ReadGridFiles(const std::string& folder);

}  // namespace plslam::exports
