// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>

#include "core/io/maps/map_file.h"
#include "core/io/trajectories/trajectory.h"

namespace plslam {

/// What a map file, or the folder of a run, has in it.
struct RunSource {
  /// Empty where the source is a map file.
  std::string folder;
  /// Empty where there is no map.
  std::string map_path;
  std::optional<StoredMap> map;
  /// T_w_l of all frames (`trajectory.tum` of the folder).
  Trajectory frames;
};

/// `path` is a map file (.plmap), or a folder with one of them or a `trajectory.tum`, or both. Throws
/// std::runtime_error where there is neither, or more than one map. `map` is taken instead of the map in the folder,
/// where it is not empty.
RunSource ReadRunSource(const std::string& path, const std::string& map = "");

}  // namespace plslam
