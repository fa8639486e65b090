// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <map>
#include <vector>

#include "core/map/map_graph.h"
#include "core/optim/pose_graph/pose_graph.h"

namespace plslam {

/// Standard deviation of the motion between two keyframes of a map that share a hundred landmarks, for each metre of
/// their distance. (A rotation of a radian counts as a metre.)
struct MapDrift {
  double per_m = 0.02;
  double deg_per_m = 0.1;
};

struct MapPoseGraph {
  /// Ascending; as long as `problem.poses`.
  std::vector<int64_t> keyframe_ids;
  PoseGraphProblem problem;

  /// Index of a keyframe among the poses; it must be one of them.
  int IndexOf(int64_t keyframe_id) const;
};

/// The pose graph of a map (PL-SLAM §VI.B), in which loops are closed and which is exported: the keyframes of
/// `T_w_kf` where they start, the first one fixed, and the edges of `graph` between them.
///
/// An edge says that two keyframes lie to each other as they do in the map, which is better than the motion that
/// odometry first measured. It is as certain as `drift` says, more where the two share many landmarks and less where
/// few; a closed loop is as certain as it was measured. An edge that is not known lets its keyframes lie as they do
/// in `T_w_kf`.
MapPoseGraph PoseGraphOf(const Map& map, const MapGraph& graph, const std::map<int64_t, SE3>& T_w_kf,
                         const MapDrift& drift);

/// The same of all keyframes of a map, as they lie there.
MapPoseGraph PoseGraphOf(const Map& map, const MapDrift& drift = {});

/// How certain that graph is of where the keyframes lie that anything connects with this one: marginal covariances of
/// their right perturbations, on top of the covariance that the first of them has. Loops count, which covariances
/// composed along the way do not know. Empty where the graph has no answer. Costs about as much as one step of the
/// optimisation.
std::map<int64_t, Matrix6d> CovariancesAround(int64_t keyframe_id, const Map& map, const MapDrift& drift = {});

}  // namespace plslam
