// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "core/map/loop_closure.h"
#include "core/map/map.h"

namespace plslam::mapping {

/// Returns the same edge with its ends exchanged.
LoopEdge Reversed(const LoopEdge& edge);

/// Returns the edges of a loop between keyframes of the map, the older one first. An end that was culled since the
/// loop was found is replaced by the next keyframe of its session; the map's keyframes are already at their corrected
/// poses. Omits edges whose ends coincide, and edges whose culled end has no name or pose in the closure.
std::vector<LoopEdge> EdgesInMap(const LoopClosure& closure, const Map& map);

}  // namespace plslam::mapping
