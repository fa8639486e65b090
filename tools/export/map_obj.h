// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "core/map/map.h"

namespace plslam::exports {

/// The map as a Wavefront OBJ file: text, in metres in w. Three objects: `points` (p elements), `lines` and
/// `keyframes` (l elements), of which the last is the way through the keyframes' positions, a polyline for each
/// session with two keyframes or more. Vertices have colours (`v x y z r g b`, 0 to 1) as those of MapPly, keyframes
/// black; programs that do not know vertex colours pass over them.
std::string MapObj(const Map& map);

}  // namespace plslam::exports
