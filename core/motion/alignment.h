// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <optional>

#include "core/geometry/se3.h"
#include "core/geometry/triangulation.h"

namespace plslam {

/// Returns the rigid motion T_a_b that takes three points of b to three of a with the least sum of squares, in closed
/// form (Umeyama, PAMI 1991, without scale). Returns nullopt if the points are nearly collinear, or the triangles too
/// different (a side differs by more than half).
std::optional<SE3> AlignPoints(const std::array<Eigen::Vector3d, 3>& b, const std::array<Eigen::Vector3d, 3>& a);

/// Returns the rigid motion T_a_b that takes two lines of b to two of a. Directions, from p to q, determine the
/// rotation; the translation then minimises the distances of the lines, with endpoints free to slide. Returns nullopt
/// if the lines are nearly parallel (sine of their angle below `min_sine`).
std::optional<SE3> AlignLines(const Segment3& first_b, const Segment3& second_b, const Segment3& first_a,
                              const Segment3& second_a, double min_sine);

}  // namespace plslam
