// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "core/geometry/se3.h"
#include "core/map/map.h"

namespace plslam {

/// Returns the level frame of ROS (x forward, y left, z up) at the origin of the map: p_world = T_world_w p_w.
SE3 LevelFromMap(const Map& map);
/// The same without a map: as if the first camera had been level.
SE3 LevelFromCamera();

}  // namespace plslam
