// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "core/optim/pose_graph/pose_graph.h"

namespace plslam {

/// Why the graph cannot be optimised, in one sentence; empty where it can.
template <class Pose>
std::string PoseGraphObjection(const PoseGraph<Pose>& graph);

/// Which poses stay as they are: the fixed ones, those without an edge, and the first of each connected part that has
/// no fixed one. Edges that are `rejected` connect nothing; an empty vector rejects none.
template <class Pose>
std::vector<bool> ConstantPoses(const PoseGraph<Pose>& graph, const std::vector<bool>& rejected);

}  // namespace plslam
