// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>

#include "core/config/choices.h"
#include "core/config/fields.h"

namespace plslam {

/// ORB points (PL-SLAM §IV.A).
struct OrbOptions {
  int max_points = 1000;
  /// Levels of the image pyramid.
  int levels = 8;
  /// Size ratio of consecutive levels.
  double scale_factor = 1.2;
  int fast_threshold = 20;
  int min_fast_threshold = 7;
  /// Least ratio of the smaller to the larger eigenvalue of the gradients around a corner; below, it is an edge.
  double min_corner_ratio = 0.1;
};

/// Detectors of line segments: this project's, which is fast, or the paper's.
enum class Segments { kEdgeChain, kLsd };
constexpr auto ChoicesOf(Segments) {
  return std::array{Choice{"edgechain", Segments::kEdgeChain}, Choice{"lsd", Segments::kLsd}};
}

/// Line segments and their descriptors (PL-SLAM §IV.B).
struct LineOptions {
  Segments detector = Segments::kEdgeChain;
  int max_lines = 200;
  double min_length_px = 20.0;
  /// Least contrast across a segment, grey levels; edgechain only.
  double min_contrast = 8.0;
  /// Number of images searched if few lines are sharp: whole, half, quarter ...
  int levels = 3;
  /// Size of the image used by LSD, relative to the input.
  double lsd_scale = 1.2;
};

/// Matching of lines between frames, by projection or by descriptors alone.
struct LineMatchOptions {
  /// Largest difference of direction from the prediction.
  double max_angle_deg = 12.0;
  /// Largest distance of the shorter segment's midpoint from the infinite line through the longer one.
  double max_across_px = 20.0;
  /// Least overlap along the line, relative to the shorter of the two.
  double min_overlap = 0.3;
  /// Least ratio of the shorter to the longer segment.
  double min_length_ratio = 0.25;
  /// Most differing descriptor bits of a match.
  int max_descriptor_distance = 70;
  /// Largest ratio of the best to the second best descriptor distance.
  double max_ratio = 0.85;
};

/// Stereo matching of both feature types (PL-SLAM §IV.A-B).
struct StereoOptions {
  double min_disparity_px = 0.5;
  double max_disparity_px = 256.0;
  /// Standard deviation of the row of a right measurement relative to the left one: accuracy of the rectification.
  double row_sigma_px = 0.3;
  /// Points: standard deviation of a position, for octave 0; proportional to the scale.
  double point_sigma_px = 0.5;
  /// Largest difference of rows, for octave 0; proportional to the scale.
  double point_row_tolerance_px = 2.0;
  /// Most differing descriptor bits of a match.
  int point_max_descriptor_distance = 80;
  /// Largest ratio of the best to the second best descriptor distance (the paper uses 0.5).
  double point_max_ratio = 0.9;
  /// Least normalised correlation of the aligned patches.
  double point_min_correlation = 0.8;
  /// Whether the row of the right image is also searched for the patches of points without a matching corner
  /// ("direct").
  bool point_direct = true;
  /// Least correlation of such a match.
  double point_direct_min_correlation = 0.9;
  /// Largest ratio of 1 - correlation at the best position to that at the second best.
  double point_direct_max_ratio = 0.6;
  /// Largest standard deviation of a disparity, for octave 0; above it the point has no depth.
  double point_max_sigma_disparity_px = 0.5;
  /// Depth cameras: the standard deviation of a depth Z is this times Z^2.
  double depth_noise_per_m = 0.002;
  /// Lines: least angle to the baseline for a depth.
  double line_min_angle_deg = 10.0;
  /// Largest angle between the left and the right direction.
  double line_max_angle_difference_deg = 25.0;
  /// Least ratio of the shorter to the longer segment.
  double line_min_length_ratio = 0.3;
  /// Least overlap of rows, relative to the shorter segment.
  double line_min_overlap = 0.4;
  /// Most differing descriptor bits of a match.
  int line_max_descriptor_distance = 70;
  /// Largest ratio of the best to the second best descriptor distance.
  double line_max_ratio = 0.85;
  /// Least ratio of the smaller to the larger endpoint disparity.
  double line_min_disparity_ratio = 0.2;
  /// Least correlation of the images along the segment, on its more similar side.
  double line_min_similarity = 0.75;
  /// Largest standard deviation of an endpoint disparity; above it the line has no depth.
  double line_max_sigma_disparity_px = 2.0;
};

/// Matching of descriptors between images.
struct MatchOptions {
  /// Most differing descriptor bits of a match.
  int max_distance = 64;
  /// Largest ratio of the best to the second best distance; 1 disables the test.
  double ratio = 0.85;
  /// Octaves by which a match may differ from the prediction.
  int octave_window = 1;
  /// Whether to reject matches whose rotation disagrees with most others.
  bool check_rotation = false;
};

/// Feature types in use: points are the paper's P-SLAM, lines L-SLAM, both PL-SLAM.
enum class FeatureTypes { kPoints, kLines, kBoth };
constexpr auto ChoicesOf(FeatureTypes) {
  return std::array{Choice{"points", FeatureTypes::kPoints}, Choice{"lines", FeatureTypes::kLines},
                    Choice{"both", FeatureTypes::kBoth}};
}

struct FeatureOptions {
  FeatureTypes features = FeatureTypes::kBoth;
  OrbOptions orb;
  LineOptions lines;
};

template <class Visitor>
void VisitFields(Visitor& visit, OrbOptions& o) {
  visit("max_points", o.max_points, Bounds{0, 20000}, "largest number of points per image");
  visit("fast_threshold", o.fast_threshold, Bounds{2, 100}, "contrast of a FAST corner, grey levels");
  visit("min_fast_threshold", o.min_fast_threshold, Bounds{2, 100}, "the same where the first threshold finds none");
}

template <class Visitor>
void VisitFields(Visitor& visit, LineOptions& o) {
  visit("detector", o.detector, "line segment detector");
  visit("max_lines", o.max_lines, Bounds{0, 5000},
        "largest number of segments per image: the longest ones, spread over the image");
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
  visit("features", o.features, "feature types in use");
  visit("orb", o.orb, "ORB points");
  visit("lines", o.lines, "line segments");
}

}  // namespace plslam
