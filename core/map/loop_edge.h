#pragma once

#include <cstdint>

#include "core/geometry/se3.h"

namespace plslam {

/// A loop that was closed: the motion from keyframe a to keyframe b of the map as it was verified, with the covariance of
/// its right perturbation.
struct LoopEdge {
  int64_t a = -1;
  int64_t b = -1;
  SE3 T_a_b;
  Matrix6d covariance = Matrix6d::Zero();
};

}  // namespace plslam
