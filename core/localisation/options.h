#pragma once

#include "core/config/fields.h"
#include "core/features/options.h"
#include "core/motion/options.h"

namespace plslam {

/// How a keyframe is found among the landmarks of the map.
struct LocalisationOptions {
  double search_radius_px = 8.0;
  int orb_levels = 8;
  double orb_scale_factor = 1.2;
  MatchOptions point_matching;
  LineMatchOptions line_matching;
  MotionOptions motion;
};

template <class Visitor>
void VisitFields(Visitor& visit, LocalisationOptions& o) {
  visit("search_radius_px", o.search_radius_px, Bounds{0.5, 1000}, "window in which landmarks are searched");
  visit("orb_levels", o.orb_levels, Bounds{1, 12}, "as vo.features.orb.levels");
  visit("orb_scale_factor", o.orb_scale_factor, Bounds{1.05, 2.0}, "as vo.features.orb.scale_factor");
  visit("point_matching", o.point_matching, "matching of points");
  visit("line_matching", o.line_matching, "matching of lines");
  visit("motion", o.motion, "pose among the landmarks");
}

}  // namespace plslam
