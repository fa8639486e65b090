#pragma once

#include "core/features/features.h"
#include "core/places/bag_of_words.h"

namespace plslam {

/// What a place looks like: all that recognition keeps of an image.
struct PlaceDescription {
  BagOfWords points;
  BagOfWords lines;
  int n_points = 0;
  int n_lines = 0;
  /// Square root of the summed variances of u and v, of the points and of the middles of the lines.
  double dispersion_points_px = 0.0;
  double dispersion_lines_px = 0.0;
};

/// Counts and dispersions of an image, without words. Features whose place is not finite do not count for the dispersion;
/// that of fewer than two is 0.
PlaceDescription DescribeLayout(const ImageFeatures& features);
PlaceDescription DescribeLayout(const StereoFeatures& features);

}  // namespace plslam
