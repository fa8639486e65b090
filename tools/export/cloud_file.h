// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/map/surface_cloud.h"

namespace plslam::exports {

/// Reads the surface points in w that dense_process has written to the folder of a run (cloud.ply); nullopt if there is no such
/// file. Throws std::runtime_error with the file and its fault.
std::optional<std::vector<SurfacePoint>> ReadCloudFile(const std::string& folder);

}  // namespace plslam::exports
