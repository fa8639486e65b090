#pragma once

#include <cstdint>
#include <vector>

#include "core/map/map.h"
#include "core/optim/pose_graph/pose_graph.h"

namespace plslam {

struct MapPoseGraph {
  /// Ascending; as long as `graph.poses`.
  std::vector<int64_t> keyframe_ids;
  PoseGraphProblem graph;
};

/// The pose graph of a map (PL-SLAM §VI.B): one edge for each pair of keyframes that the spanning tree, the order of a
/// session or the essential graph joins, and one for each closed loop and each of `more_loops` whose keyframes are in the
/// map. The first keyframe is fixed. Loop edges are robust and come last.
///
/// The other edges say that keyframes lie to each other as they do in the map, which is better than the motion that
/// odometry first measured; they are as certain as odometry between the two was, and those to one keyframe share what it
/// knew. Where odometry does not lead from one to the other in a few steps (landmarks seen again) an edge is as
/// certain as the step to the younger keyframe, less where they share fewer landmarks than that step.
MapPoseGraph PoseGraphOf(const Map& map, const std::vector<LoopEdge>& more_loops = {});

}  // namespace plslam
