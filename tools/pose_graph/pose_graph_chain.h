// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "core/optim/pose_graph/pose_graph.h"

namespace plslam::pose_graph {

/// Poses chained along the edges from the `known` ones, which stay; in a part of the graph without a known pose its
/// first one is where it is given. Edges between poses that follow each other (odometry) come first, the others in
/// their order, and none that closes a circle. An empty `known` means: the fixed ones.
template <class Pose>
std::vector<Pose> ChainedPoses(const PoseGraph<Pose>& graph, std::vector<bool> known = {});

}  // namespace plslam::pose_graph
