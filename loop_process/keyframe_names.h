#pragma once

#include <vector>

#include "core/map/map.h"

namespace plslam {

/// Names of those keyframes that edges and poses of the closure speak of and the map has, ascending by id.
std::vector<KeyframeName> NamesIn(const Map& map, const LoopClosure& closure);

}  // namespace plslam
