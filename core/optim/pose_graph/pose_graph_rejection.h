// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "core/optim/pose_graph/pose_graph.h"

namespace plslam {

/// By how much the least chi-square falls when an edge is taken out, to first order at the optimum: r^T (I - J C
/// J^T)^-1 r with the edge's whitened residual r, its derivatives J and the covariance C of its ends (deletion
/// statistic; Baarda's data snooping). Equally the squared Mahalanobis distance of the edge from what all others
/// predict. Zero for edges that are rejected or not robust, and where nothing else predicts the edge. Empty where the
/// graph is singular.
template <class Pose>
std::vector<double> DeletionGains(const PoseGraph<Pose>& graph, const std::vector<Pose>& T_w_kf,
                                  const std::vector<bool>& rejected);

}  // namespace plslam
