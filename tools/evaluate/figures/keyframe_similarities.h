// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "core/io/maps/map_file.h"
#include "core/places/place_recogniser.h"
#include "tools/evaluate/places/place_evaluation.h"

namespace plslam {

/// Similarities of a map's keyframes, in their order, by points, lines and both (PL-SLAM fig. 5).
struct KeyframeSimilarities {
  /// Every so many-th keyframe is among them.
  int step = 1;
  SimilarityMatrix points;
  SimilarityMatrix lines;
  SimilarityMatrix merged;
};

/// Of at most `most` keyframes. The recogniser should have no places: words count the same for each pair then.
KeyframeSimilarities SimilaritiesOf(const StoredMap& stored, const PlaceRecogniser& recogniser, int most);

}  // namespace plslam
