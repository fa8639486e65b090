// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "core/config/fields.h"

namespace plslam {

/// ORB points (PL-SLAM §IV.A).
struct OrbOptions {
  int max_points = 1000;
  /// Levels of the image pyramid.
  int levels = 8;
  /// Size ratio of neighbouring levels.
  double scale_factor = 1.2;
  int fast_threshold = 20;
  int min_fast_threshold = 7;
  /// Smaller to larger eigenvalue of the gradients around a corner; below, it is an edge.
  double min_corner_ratio = 0.1;
};

/// Line segments and their descriptors (PL-SLAM §IV.B).
struct LineOptions {
  /// "edgechain" (this tree's, fast) or "lsd" (the paper's).
  std::string detector = "edgechain";
  int max_lines = 200;
  double min_length_px = 20.0;
  /// Contrast across a segment, grey levels; edgechain only.
  double min_contrast = 8.0;
  /// Images that are searched where few lines are sharp: whole, half, quarter ...
  int levels = 3;
  /// Size of the image LSD works on, relative to the input.
  double lsd_scale = 1.2;
};

/// Matching of lines between frames, by projection or by descriptors alone.
struct LineMatchOptions {
  /// Difference of direction from the prediction.
  double max_angle_deg = 12.0;
  /// Distance of the feature's endpoints from the predicted infinite line, and the other way round.
  double max_across_px = 20.0;
  /// Shared part along the line, relative to the shorter of the two; and shorter to longer length.
  double min_overlap = 0.3;
  /// Shorter to longer segment.
  double min_length_ratio = 0.25;
  /// Differing bits of a match.
  int max_descriptor_distance = 70;
  /// Best to second best descriptor distance.
  double max_ratio = 0.85;
};

/// Stereo matching of both feature types (PL-SLAM §IV.A-B).
struct StereoOptions {
  double min_disparity_px = 0.5;
  double max_disparity_px = 256.0;
  /// Standard deviation of the row of a right measurement against the left one: how well the pair is rectified.
  double row_sigma_px = 0.3;
  /// Points: standard deviation of a position, and tolerance of rows, both for octave 0; they grow with the scale.
  double point_sigma_px = 0.5;
  /// Difference of rows, for octave 0.
  double point_row_tolerance_px = 2.0;
  /// Differing bits of a match.
  int point_max_descriptor_distance = 80;
  /// Best to second best descriptor distance (the paper asks for 0.5).
  double point_max_ratio = 0.9;
  /// Normalised correlation of the aligned patches.
  double point_min_correlation = 0.8;
  /// Also search the row of the right image for the patches of points without a matching corner ("direct"), asking
  /// for this correlation, and for a second best whose distance to 1 is larger by this factor.
  bool point_direct = true;
  /// Correlation of such a match.
  double point_direct_min_correlation = 0.9;
  /// 1 - correlation of the best place over that of the second, at most.
  double point_direct_max_ratio = 0.6;
  /// Largest standard deviation of a disparity, for octave 0; above it the point has no depth.
  double point_max_sigma_disparity_px = 0.5;
  /// Depth cameras: standard deviation of a depth Z is this times Z^2.
  double depth_noise_per_m = 0.002;
  /// Lines: least angle to the baseline for a depth, and the largest difference of directions.
  double line_min_angle_deg = 10.0;
  /// Left to right direction.
  double line_max_angle_difference_deg = 25.0;
  /// Shorter to longer segment, and shared rows relative to the shorter one.
  double line_min_length_ratio = 0.3;
  /// Shared rows, of the shorter segment.
  double line_min_overlap = 0.4;
  /// Differing bits of a match.
  int line_max_descriptor_distance = 70;
  /// Best to second best descriptor distance.
  double line_max_ratio = 0.85;
  /// Smaller to larger endpoint disparity.
  double line_min_disparity_ratio = 0.2;
  /// Correlation of the images along the segment, of its more similar side.
  double line_min_similarity = 0.75;
  /// Largest standard deviation of an endpoint disparity; above it the line has no depth.
  double line_max_sigma_disparity_px = 2.0;
};

/// Matching of descriptors between images.
struct MatchOptions {
  /// Largest number of differing descriptor bits of a match.
  int max_distance = 64;
  /// Best distance over second best, at most; 1 switches the test off.
  double ratio = 0.85;
  /// Octaves by which a match may differ from the prediction.
  int octave_window = 1;
  /// Reject matches whose turn disagrees with most others.
  bool check_rotation = false;
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
  visit("fast_threshold", o.fast_threshold, Bounds{2, 100}, "contrast of a FAST corner, grey levels");
  visit("min_fast_threshold", o.min_fast_threshold, Bounds{2, 100}, "the same where the first finds none");
}

template <class Visitor>
void VisitFields(Visitor& visit, LineOptions& o) {
  visit("detector", o.detector, OneOf{"edgechain", "lsd"}, "line segment detector");
  visit("max_lines", o.max_lines, Bounds{0, 5000}, "segments kept in an image, the longest, spread");
  visit("min_length_px", o.min_length_px, Bounds{8, 1000}, "shortest segment kept");
  visit("min_contrast", o.min_contrast, Bounds{2, 100}, "contrast across a segment, grey levels (edgechain)");
}

template <class Visitor>
void VisitFields(Visitor& visit, StereoOptions& o) {
  visit("min_disparity_px", o.min_disparity_px, Bounds{0.01, 100}, "smallest disparity with a depth");
  visit("max_disparity_px", o.max_disparity_px, Bounds{1, 2000}, "largest disparity searched");
  visit("depth_noise_per_m", o.depth_noise_per_m, Bounds{1e-5, 1}, "depth cameras: sigma of a depth over its square");
}

template <class Visitor>
void VisitFields(Visitor& visit, FeatureOptions& o) {
  visit("features", o.features, OneOf{"points", "lines", "both"}, "kinds of features in use");
  visit("orb", o.orb, "ORB points");
  visit("lines", o.lines, "line segments");
}

}  // namespace plslam
