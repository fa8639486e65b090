// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "core/optim/pose_graph/pose_graph.h"

namespace plslam {

template <class Pose>
struct PoseGraphSolve {
  bool ok = false;
  std::vector<Pose> T_w_kf;
  double chi2 = 0.0;
  int iterations = 0;
};

/// Runs Levenberg-Marquardt over the edges that are not rejected, from `start`. Expects a valid graph; `ok` is false if
/// the solver fails or its result is not finite.
template <class Pose>
PoseGraphSolve<Pose> SolvePoseGraph(const PoseGraph<Pose>& graph, const std::vector<bool>& rejected,
                                    const std::vector<Pose>& start, const PoseGraphOptions& options);

}  // namespace plslam
