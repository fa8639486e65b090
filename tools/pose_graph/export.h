#pragma once

#include "core/io/g2o.h"
#include "core/io/trajectory.h"
#include "core/map/map.h"

namespace plslam {

/// Poses of a graph; the number of the vertex stands for the time, in seconds.
Trajectory TrajectoryOf(const G2oGraph<SE3>& graph);
Trajectory TrajectoryOf(const G2oGraph<SE2>& graph);

/// Keyframes by time, T_w_kf. Of several at one time, as sessions may have, the first.
Trajectory TrajectoryOf(const Map& map);

/// The pose graph of a map; vertices have the numbers of the keyframes.
G2oGraph<SE3> G2oOf(const Map& map);

}  // namespace plslam
