// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "core/io/maps/map_file.h"
#include "core/places/place_recogniser.h"
#include "tools/evaluate/drawing/drawing.h"

namespace plslam::evaluate {

/// Similarities of a row of images with each other, row by row: symmetric but for the weights, which are those of the
/// row's image in a map of all.
struct SimilarityMatrix {
  int size = 0;
  std::vector<float> values;
  float At(int row, int column) const { return values[static_cast<size_t>(row) * size + column]; }
};

/// The same images by points, by lines and by both.
struct Similarities {
  /// Every so many-th image is among them.
  int step = 1;
  SimilarityMatrix points;
  SimilarityMatrix lines;
  SimilarityMatrix merged;
};

/// Returns the similarities of at most `most` keyframes of a map, in order. The recogniser should contain no places:
/// words then have the same weight for each pair.
Similarities KeyframeSimilarities(const StoredMap& stored, const PlaceRecogniser& recogniser, int most = 400);

/// Returns the largest off-diagonal value of a matrix except for the highest half per cent; 1 without any.
float FullScale(const SimilarityMatrix& matrix);

/// The three matrices (PL-SLAM fig. 5) side by side at column width, each with its own scale: dark for 0, bright for
/// `FullScale`. `images` names the rows ("keyframes").
Drawing SimilarityFigure(const std::string& title, const Similarities& similarities, const std::string& images);

}  // namespace plslam::evaluate
