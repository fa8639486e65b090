// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

namespace plslam::exports {

/// Returns whether the map has surfaces beside it (plslam run --dense --save-map).
bool HasSurfaces(const std::string& map_path);

/// Writes files of these kinds (cloud, mesh, octomap, grid) by the program plslam_surfaces, which alone links OpenVDB and
/// OctoMap, to the folder, and returns their names. Throws std::runtime_error with the sentence of that program, or if it
/// is not installed (Debian package plslam-dense).
std::vector<std::string> WriteSurfaceFiles(const std::string& map_path, const std::string& out,
                                           const std::vector<std::string>& kinds);

}  // namespace plslam::exports
