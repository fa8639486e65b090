#pragma once

#include "core/geometry/se3.h"
#include "core/map/keyframe.h"

namespace plslam {

/// A frame whose place in the map was asked for.
struct RelocalisationQuestion {
  Keyframe sent;
  SE3 T_odom_c;
  double asked_s = 0.0;
};

}  // namespace plslam
