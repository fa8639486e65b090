// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "core/io/trajectories/trajectory.h"
#include "core/map/map.h"
#include "tools/pose_graph/g2o.h"

namespace plslam::pose_graph {

/// Returns the poses of a graph; the number of the vertex is used as the time, in seconds.
Trajectory TrajectoryOf(const G2oGraph<SE3>& graph);
Trajectory TrajectoryOf(const G2oGraph<SE2>& graph);

/// A session of a map and its keyframes by time, T_w_kf.
struct SessionTrajectory {
  /// Suffix of the file's name: empty for the session of the first keyframe, "_sN" for session N, as in COLMAP's image
  /// names.
  std::string suffix;
  Trajectory keyframes;
};

/// Returns each session separately, in the order of their first keyframes: their times may overlap or be of different
/// clocks.
std::vector<SessionTrajectory> TrajectoriesOf(const Map& map);

/// The pose graph of a map; vertices have the numbers of the keyframes.
G2oGraph<SE3> G2oOf(const Map& map);

}  // namespace plslam::pose_graph
