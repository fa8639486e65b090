// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "core/map/loop_closure.h"
#include "core/map/map.h"

namespace plslam::mapping {

/// The same edge from its other end.
LoopEdge Reversed(const LoopEdge& edge);

/// The edges of a loop as a map can keep them: of two of its keyframes, the older first. An end that was culled since
/// the loop was found is replaced by the next keyframe of its session; the map's keyframes already lie where the
/// correction puts them. An edge of which both ends would be one, or of whose end nothing is said, is left out.
std::vector<LoopEdge> EdgesInMap(const LoopClosure& closure, const Map& map);

}  // namespace plslam::mapping
