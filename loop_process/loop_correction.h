#pragma once

#include <optional>
#include <vector>

#include "core/map/loop_closure.h"
#include "core/map/map.h"
#include "core/optim/pose_graph.h"
#include "loop_process/options.h"

namespace plslam {

/// The pose graph of a map with one loop more (PL-SLAM §VI.B). Nodes are the keyframes in order of their ids, the first fixed; edges what
/// connects them (see map_edges.h) as the map has it now, and at the end the loop, which alone may be rejected. Where nothing
/// connects the two sides of the loop, the side that began later starts where the loop puts it.
PoseGraphProblem MakeLoopGraph(const Map& map, const LoopEdge& loop, const CorrectionOptions& options);

/// Where the keyframes lie when the loop is closed, all of them, ascending. nullopt where the graph contradicts the loop,
/// or cannot be solved.
std::optional<std::vector<CorrectedPose>> CloseLoop(const Map& map, const LoopEdge& loop,
                                                    const CorrectionOptions& options);

}  // namespace plslam
