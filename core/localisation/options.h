// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "core/features/options.h"
#include "core/motion/options.h"

namespace plslam {

/// How a keyframe is found among the landmarks of the map.
struct LocalisationOptions {
  /// Window in which landmarks are searched.
  double search_radius_px = 8.0;
  /// Octaves of the features are those of the tracker's extractor.
  int orb_levels = OrbOptions{}.levels;
  double orb_scale_factor = OrbOptions{}.scale_factor;
  MatchOptions point_matching;
  LineMatchOptions line_matching;
  MotionOptions motion;
};

}  // namespace plslam
