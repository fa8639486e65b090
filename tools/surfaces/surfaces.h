// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>
#include <vector>

namespace plslam::surfaces {

struct SurfacesRequest {
  std::string map;                       ///< MAP.plmap; its surfaces are in MAP.plmap.surfaces
  std::string out;                       ///< folder; it is made
  std::vector<std::string> kinds;        ///< of dense::kProductKinds
  std::optional<double> robot_height_m;  ///< nullopt: that of the run
  std::vector<double> up_c;              ///< as for `VerticalOf`; empty: that of the run
};

/// Merges the surfaces with the keyframes where the map has them now, writes the files of these kinds and frames.json,
/// and returns their names. Throws std::runtime_error with one sentence that names the file: one that is missing or
/// damaged, surfaces of another map, or a grid without a floor.
std::vector<std::string> WriteSurfaces(const SurfacesRequest& request);

}  // namespace plslam::surfaces
