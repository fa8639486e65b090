// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "core/features/options.h"
#include "core/motion/options.h"

namespace plslam {

/// Localisation of a keyframe among the landmarks of the map.
struct LocalisationOptions {
  /// Radius of the search around the projected landmark.
  double search_radius_px = 8.0;
  /// Octaves of the tracker's ORB extractor.
  int orb_levels = OrbOptions{}.levels;
  double orb_scale_factor = OrbOptions{}.scale_factor;
  MatchOptions point_matching;
  LineMatchOptions line_matching;
  MotionOptions motion;
};

}  // namespace plslam
