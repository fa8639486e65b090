// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "core/optim/pose_graph/pose_graph.h"

namespace plslam::pose_graph {

/// Returns poses chained along the edges from the `known` ones, which are unchanged; in a part of the graph without a
/// known pose, its first one is the given one. Edges between consecutive poses (odometry) come first, then the others
/// in their order, except those that close a cycle. An empty `known` means: the fixed ones.
template <class Pose>
std::vector<Pose> ChainedPoses(const PoseGraph<Pose>& graph, std::vector<bool> known = {});

}  // namespace plslam::pose_graph
