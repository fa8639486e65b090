// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "core/map/map.h"

namespace plslam {

/// The landmarks as a PLY file (binary, little endian) that CloudCompare and MeshLab open, in metres in w. Vertices
/// are the points, then both ends of each line, with x, y, z, red, green, blue, and the number of keyframes that see
/// the landmark (`observations`); edges join the ends of the lines. Points are coloured by height, low blue to high
/// red (up is that of VerticalOf); lines by observations, violet for few to green for 20 and more. The order is that
/// of the ids.
std::string MapPly(const Map& map);

}  // namespace plslam
