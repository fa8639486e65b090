// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "core/optim/pose_graph/pose_graph.h"

namespace plslam {

/// Returns for each edge the gain in minimal chi-square if it is removed, to first order at the optimum:
/// r^T (I - J C J^T)^-1 r with the edge's whitened residual r, its derivatives J and the covariance C of its ends
/// (deletion statistic; Baarda's data snooping). It equals the squared Mahalanobis distance of the edge from the
/// prediction of all others. Zero for edges that are rejected, not robust, or not predicted by others. Empty if the
/// graph is singular.
template <class Pose>
std::vector<double> DeletionGains(const PoseGraph<Pose>& graph, const std::vector<Pose>& T_w_kf,
                                  const std::vector<bool>& rejected);

}  // namespace plslam
