// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <map>
#include <vector>

#include "core/map/map_graph.h"
#include "core/optim/pose_graph/pose_graph.h"

namespace plslam {

/// Standard deviation of the motion between two keyframes of a map that share a hundred landmarks, per metre of their
/// distance. (A rotation of one radian counts as a metre.)
struct MapDrift {
  double per_m = 0.02;
  double deg_per_m = 0.1;
};

struct MapPoseGraph {
  /// Ascending; same length as `problem.poses`.
  std::vector<KeyframeId> keyframe_ids;
  PoseGraphProblem problem;

  /// Returns the index of a keyframe among the poses, which must contain it.
  int IndexOf(KeyframeId keyframe_id) const;
};

/// Returns the pose graph of a map (PL-SLAM §VI.B), for loop correction and export: the keyframes of `T_w_kf` with
/// these start poses, the first one fixed, and the edges of `graph` between them.
///
/// An edge measures the relative pose of two keyframes in the map, which is more accurate than the motion first
/// measured by odometry. Its covariance follows from `drift`, smaller if the two share many landmarks and larger if
/// few; a closed loop has its measured covariance. An unknown edge measures the relative pose in `T_w_kf`.
MapPoseGraph PoseGraphOf(const Map& map, const MapGraph& graph, const std::map<KeyframeId, SE3>& T_w_kf,
                         const MapDrift& drift);

/// As above, for all keyframes of a map at their poses.
MapPoseGraph PoseGraphOf(const Map& map, const MapDrift& drift = {});

/// Returns covariances of the keyframes connected with this one, except the first of them: marginals of their right
/// perturbations in the pose graph, composed with the covariance of the first. They include the information of loops,
/// which covariances composed along odometry lack. Empty if the graph is singular. Costs about as much as one step of
/// the optimisation.
std::map<KeyframeId, Matrix6d> CovariancesAround(KeyframeId keyframe_id, const Map& map, const MapDrift& drift = {});

}  // namespace plslam
