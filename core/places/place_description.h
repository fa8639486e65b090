// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "core/features/features.h"

namespace plslam {

/// An image as the words of a vocabulary that it contains (PL-SLAM §VI.A.1).
struct BagOfWords {
  /// (word, weight), ascending by word; TF-IDF weights above 0 that sum to 1. Empty if the image has no known word.
  std::vector<std::pair<int32_t, float>> words;

  bool operator==(const BagOfWords&) const = default;
};

/// Returns 1 - |a - b|_1 / 2 (Galvez-Lopez and Tardos, T-RO 2012). For weights that sum to 1 this is the common weight
/// sum_w min(a_w, b_w): 0 without a common word, 1 for equal bags, symmetric.
float BagSimilarity(const BagOfWords& a, const BagOfWords& b);

/// The same with the common weight of the i-th word of `a` multiplied by `word_weights[i]`: at most 1, not symmetric.
float BagSimilarity(const BagOfWords& a, const std::vector<float>& word_weights, const BagOfWords& b);

/// The description of an image that place recognition stores.
struct PlaceDescription {
  BagOfWords points;
  BagOfWords lines;
  int n_points = 0;
  int n_lines = 0;
  /// Square root of the summed variances of u and v, of the points and of the midpoints of the lines.
  double dispersion_points_px = 0.0;
  double dispersion_lines_px = 0.0;
};

/// Returns counts and dispersions of an image, without words. Features whose position is not finite do not count for
/// the dispersion; that of fewer than two features is 0.
PlaceDescription DescribeLayout(const ImageFeatures& features);
PlaceDescription DescribeLayout(const FeaturesView& features);

}  // namespace plslam
