#pragma once

#include <cstdint>
#include <vector>

#include "core/map/map.h"

namespace plslam {

/// Names of those of the keyframes that the map has, ascending by id.
std::vector<KeyframeName> NamesIn(const Map& map, const std::vector<int64_t>& keyframe_ids);

/// Names of all keyframes that edges and poses of the closure speak of.
std::vector<KeyframeName> NamesIn(const Map& map, const LoopClosure& closure);

}  // namespace plslam
