#pragma once

#include <cstdint>
#include <optional>

#include "core/geometry/se3.h"
#include "core/map/keyframe.h"

namespace plslam {

/// A frame whose place in the map was asked for.
struct RelocalisationQuestion {
  int64_t frame_id = -1;
  SE3 T_odom_c;
  double asked_s = 0.0;
  /// As it was sent.
  Keyframe sent;
};

}  // namespace plslam
