// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <vector>

#include "core/optim/pose_graph/pose_graph.h"

namespace plslam {

/// Computes start poses that depend on the given ones only through the constant poses: rotations from the edges alone
/// by chordal relaxation (sum of k |R_w_b - R_w_a R_a_b|^2 over matrices, linear; then the nearest rotations), and
/// the translations that minimise the chi-square given these, which is linear, too. See Carlone, Tron, Daniilidis,
/// Dellaert, "Initialization techniques for 3D SLAM", ICRA 2015. Uses all edges, including robust ones.
///
/// Expects a valid graph (`PoseGraphObjection`) and `constant` from ConstantPoses. Returns nullopt if a system is
/// singular.
template <class Pose>
std::optional<std::vector<Pose>> ChordalPoses(const PoseGraph<Pose>& graph, const std::vector<bool>& constant);

}  // namespace plslam
