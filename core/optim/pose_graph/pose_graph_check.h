// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "core/optim/pose_graph/pose_graph.h"

namespace plslam {

/// Returns why the graph cannot be optimised, in one sentence; empty if it can.
template <class Pose>
std::string PoseGraphObjection(const PoseGraph<Pose>& graph);

/// Marks the constant poses: the fixed ones, those without an edge, and the first of each connected part without a
/// fixed one. `rejected` edges do not connect; an empty vector rejects none.
template <class Pose>
std::vector<bool> ConstantPoses(const PoseGraph<Pose>& graph, const std::vector<bool>& rejected);

}  // namespace plslam
