#pragma once

#include <vector>

#include "core/geometry/se3.h"

namespace plslam {

/// T_a_b that takes the positions of poses in b nearest to those of the same poses in a, by least squares without scale;
/// where they lie on a line (or are fewer than three), that of the first pose. Identity without poses. Vectors are
/// equally long.
SE3 AlignPoses(const std::vector<SE3>& a, const std::vector<SE3>& b);

}  // namespace plslam
