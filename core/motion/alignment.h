// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <optional>

#include "core/geometry/se3.h"
#include "core/geometry/triangulation.h"

namespace plslam {

/// Rigid motion that takes three points of b to three of a with the smallest sum of squares, in closed form (Umeyama,
/// PAMI 1991, without scale): T_a_b. nullopt where the points are nearly collinear, or the triangles too unlike
/// to be the same (a side differs by more than half).
std::optional<SE3> AlignPoints(const std::array<Eigen::Vector3d, 3>& b, const std::array<Eigen::Vector3d, 3>& a);

/// Rigid motion that takes two lines of b to two of a: T_a_b. Directions fix the rotation, then the translation
/// is the one that takes the lines closest to each other, endpoints being free to slide. Directions are
/// those from p to q. nullopt where the lines are nearly parallel (sine of their angle below `min_sine`).
std::optional<SE3> AlignLines(const Segment3& first_b, const Segment3& second_b, const Segment3& first_a,
                              const Segment3& second_a, double min_sine);

}  // namespace plslam
