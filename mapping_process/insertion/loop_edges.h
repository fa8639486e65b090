// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "core/map/loop_closure.h"
#include "core/map/map.h"

namespace plslam::mapping {

/// Returns the same edge with its ends exchanged.
LoopEdge Reversed(const LoopEdge& edge);

/// Loops that a removed keyframe has passed on to another one.
struct PassedOnLoops {
  std::vector<LoopEdge> edges;
  /// The keyframe was the last one of its session: only edges are needed that connect parts of the map.
  bool ends_session = false;
};

/// To be called before the removal of a keyframe. Its loops move to the keyframe before or after it in its session,
/// the one to which its motion is known better; without any, to its parent, or else to the other end of its first loop.
/// The pose relative to that keyframe is the map's; the covariance of the motion or of the first loop is added (for a
/// parent, none). Omits loops with that keyframe.
PassedOnLoops LoopsPassedOn(KeyframeId removed_id, const Map& map);

/// To be called after the removal. Omits edges between keyframes that have another loop, or share enough landmarks for
/// the essential graph.
void AddNeeded(const PassedOnLoops& loops, Map& map);

/// Returns the edges of a loop between keyframes of the map, the older one first. An end that was culled since the
/// loop was found is replaced by the next keyframe of its session; the map's keyframes are already at their corrected
/// poses. Omits edges whose ends coincide, and edges whose culled end has no name or pose in the closure.
std::vector<LoopEdge> EdgesInMap(const LoopClosure& closure, const Map& map);

}  // namespace plslam::mapping
