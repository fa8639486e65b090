// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "core/places/place_recogniser.h"
#include "tools/evaluate/places/precision_recall.h"
#include "tools/evaluate/places/revisits.h"

namespace plslam {

/// A frame of a sequence: where it truly was, and what it looked like.
struct PlaceFrame {
  TimedPose pose;
  PlaceDescription description;
};

/// What one way to merge the scores achieves.
struct MergeEvaluation {
  std::string merge;
  /// One proposal for each frame: the best of the earlier ones, as loop closing asks. Positives: frames that revisit.
  PrecisionRecall best_match;
  /// Every pair is a proposal, as the paper's similarity matrices show them, scored when the later frame has been
  /// seen and only what came before it is known. Positives: pairs that are revisits.
  PrecisionRecall all_pairs;
};

/// Square, symmetric but for the weights, which are those of the row's frame in a map of all; row by row.
struct SimilarityMatrix {
  int size = 0;
  std::vector<float> values;
  float At(int row, int column) const { return values[static_cast<size_t>(row) * size + column]; }
};

struct PlaceEvaluation {
  std::string name;
  int frames = 0;
  int revisiting_frames = 0;
  int revisits = 0;
  int other_places = 0;
  std::vector<MergeEvaluation> merges;
  SimilarityMatrix points;
  SimilarityMatrix lines;
  SimilarityMatrix merged;  ///< by the default merge
};

/// Names of all merges, the default first.
std::vector<std::string> MergeNames();

/// Runs the frames through a recogniser in their order, once for each merge.
PlaceEvaluation EvaluatePlaces(const std::string& name, const std::vector<PlaceFrame>& frames,
                               const Vocabulary& points, const Vocabulary& lines, const RevisitOptions& options);

}  // namespace plslam
