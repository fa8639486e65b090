// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "tools/evaluate/figures/axes.h"

namespace plslam {

/// Directions of the drawing in w, so that nothing is mirrored. From above, in the levelled frame (LevelRotation): x
/// to the right and z (forward) up, or, where the path is longer than wide, z to the right and -x (left) up. From the
/// side, with -y up, where a path climbs as far as it leads away.
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

/// Axes of equal scale at column width around the positions, below `top_pt`, and the height of the figure with them.
struct Plan {
  Box area;
  Range x;
  Range y;
  double height_pt = 0.0;
};

Plan PlanAround(const std::vector<Eigen::Vector2d>& positions, double top_pt);

}  // namespace plslam
