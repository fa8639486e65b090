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

/// Returns the similarity that takes the positions of poses in b nearest to those of the same poses in a, by least
/// squares: closed form of Umeyama (PAMI 1991). If positions do not determine the rotation (all on one line: the
/// rotation about it; all equal: all of it), the rest is chosen so that the orientations agree best. Vectors have equal
/// length. Identity without poses. Scale 1 if `with_scale` is false, or positions are equal.
Similarity AlignPaths(const std::vector<SE3>& a, const std::vector<SE3>& b, bool with_scale);

/// Returns the rotation that takes the orientations of poses in b nearest to those of the same poses in a: the chordal
/// mean of R_a R_b^T (Hartley et al., IJCV 2013). Vectors have equal length. Identity without poses.
Eigen::Quaterniond AlignOrientations(const std::vector<SE3>& a, const std::vector<SE3>& b);

}  // namespace plslam
