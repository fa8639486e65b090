// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "core/geometry/se3.h"

namespace plslam {

/// p_a = scale * R * p_b + t.
struct Similarity {
  double scale = 1.0;
  SE3 T_a_b;

  SE3 Apply(const SE3& pose) const;
};

/// What takes the positions of poses in b nearest to those of the same poses in a, by least squares: closed form of
/// Umeyama (PAMI 1991). Where positions leave the rotation open (all on one line: the turn about the line; all equal:
/// everything), the rest is chosen so that the orientations agree best. Vectors are equally long. No poses: identity.
/// Scale 1 where it is not asked for, or positions are equal.
Similarity AlignPaths(const std::vector<SE3>& a, const std::vector<SE3>& b, bool with_scale);

}  // namespace plslam
