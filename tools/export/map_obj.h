// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "core/map/map.h"

namespace plslam::exports {

/// Returns the map as a Wavefront OBJ file: text, in metres in w. Three objects: `points` (p elements), `lines` and
/// `keyframes` (l elements); the last is the path through the keyframes' positions, a polyline for each session with
/// two keyframes or more. Vertices have colours (`v x y z r g b`, 0 to 1) as those of MapPly, keyframes black; programs
/// without support for vertex colours ignore them.
std::string MapObj(const Map& map);

}  // namespace plslam::exports
