// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "core/io/trajectories/trajectory.h"
#include "core/map/map.h"
#include "tools/evaluate/drawing/axes.h"

namespace plslam::evaluate {

/// Axes of the drawing in w, chosen without mirroring. From above, in the levelled frame (LevelRotation): x to the
/// right and z (forward) up, or, where the path is longer than wide, z to the right and -x (left) up. From the side,
/// with -y up, if a path climbs as far as it extends.
struct ViewDirections {
  Eigen::Vector3d right = Eigen::Vector3d::UnitX();
  Eigen::Vector3d up = Eigen::Vector3d::UnitZ();
  std::string right_name = "x [m]";
  std::string up_name = "z [m]";

  Eigen::Vector2d operator()(const Eigen::Vector3d& p_w) const { return {right.dot(p_w), up.dot(p_w)}; }
  std::vector<Eigen::Vector2d> operator()(const std::vector<Eigen::Vector3d>& path) const;
};

/// No positions: from above. `up_w` is where up is in w.
ViewDirections ViewOf(const std::vector<Eigen::Vector3d>& positions, const Eigen::Vector3d& up_w);

/// A trajectory of a figure, positions in w.
struct NamedPath {
  std::string name;
  std::vector<Eigen::Vector3d> positions_w;
  Stroke stroke;
};

/// Returns the positions in w of a trajectory that is given in another frame.
std::vector<Eigen::Vector3d> PositionsOf(const Trajectory& trajectory, const SE3& T_w_trajectory = SE3());

/// Draws trajectories from above, at column width and equal scale, the last on top; below them in grey the landmarks of
/// `map` (may be null), at most 20,000 points. The start of the last trajectory is marked by a ring. The title is
/// above. Without a map, up is -y of w.
Drawing TopView(const std::string& title, const std::vector<NamedPath>& paths, const Map* map);

/// The covisibility graph (PL-SLAM fig. 3): keyframes, edges between those that share 20 landmarks in light green,
/// 100 (essential graph) in dark green, the spanning tree, and closed loops in red.
Drawing CovisibilityFigure(const std::string& title, const Map& map);

}  // namespace plslam::evaluate
