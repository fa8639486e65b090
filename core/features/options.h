#pragma once

#include <string>

#include "core/config/fields.h"

namespace plslam {

/// ORB points (PL-SLAM §IV.A).
struct OrbOptions {
  int max_points = 1000;
  int levels = 8;
  double scale_factor = 1.2;
  int fast_threshold = 20;
  int min_fast_threshold = 7;
};

/// Line segments and their descriptors (PL-SLAM §IV.B).
struct LineOptions {
  /// "lsd" (the paper's), "edlines", or a faster one of this tree.
  std::string detector = "lsd";
  int max_lines = 200;
  double min_length_px = 20.0;
};

/// Stereo matching of both kinds (PL-SLAM §IV.A-B).
struct StereoOptions {
  double min_disparity_px = 0.5;
  double max_disparity_px = 256.0;
};

/// "points" gives the paper's P-SLAM, "lines" L-SLAM, "both" PL-SLAM.
struct FeatureOptions {
  std::string features = "both";
  OrbOptions orb;
  LineOptions lines;
};

template <class Visitor>
void VisitFields(Visitor& visit, OrbOptions& o) {
  visit("max_points", o.max_points, Bounds{0, 20000}, "points kept in an image");
  visit("levels", o.levels, Bounds{1, 12}, "levels of the image pyramid");
  visit("scale_factor", o.scale_factor, Bounds{1.05, 2.0}, "size ratio of neighbouring levels");
  visit("fast_threshold", o.fast_threshold, Bounds{2, 100}, "contrast of a FAST corner, grey levels");
  visit("min_fast_threshold", o.min_fast_threshold, Bounds{2, 100}, "the same where the first finds none");
}

template <class Visitor>
void VisitFields(Visitor& visit, LineOptions& o) {
  visit("detector", o.detector, OneOf{"lsd", "edlines"}, "line segment detector");
  visit("max_lines", o.max_lines, Bounds{0, 5000}, "segments kept in an image, the longest");
  visit("min_length_px", o.min_length_px, Bounds{5, 1000}, "shortest segment kept");
}

template <class Visitor>
void VisitFields(Visitor& visit, StereoOptions& o) {
  visit("min_disparity_px", o.min_disparity_px, Bounds{0.01, 100}, "smallest disparity with a depth");
  visit("max_disparity_px", o.max_disparity_px, Bounds{1, 2000}, "largest disparity searched");
}

template <class Visitor>
void VisitFields(Visitor& visit, FeatureOptions& o) {
  visit("features", o.features, OneOf{"points", "lines", "both"}, "kinds of features in use");
  visit("orb", o.orb, "ORB points");
  visit("lines", o.lines, "line segments");
}

}  // namespace plslam
