// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/geometry/se3.h"
#include "core/places/place_recogniser.h"
#include "tools/evaluate/places/similarity_figure.h"

namespace plslam::evaluate {

/// Definition of a revisit and of another place. Pairs in between have partly overlapping views and count neither as
/// right nor as wrong.
struct RevisitOptions {
  /// Largest distance of a revisit, in position and in viewing direction.
  double distance_m = 1.0;
  double angle_deg = 30.0;
  /// Another place is farther away than one of these.
  double far_distance_m = 5.0;
  double far_angle_deg = 90.0;
  /// Pairs with a smaller time difference are no revisit and are ignored.
  double min_gap_s = 5.0;
};

enum class PairTruth { kIgnored, kRevisit, kOtherPlace };

/// A true pose of the camera.
struct TimedPose {
  int64_t t_ns = 0;
  SE3 T_w_c;
};

PairTruth ClassifyPair(const TimedPose& a, const TimedPose& b, const RevisitOptions& options);

/// A proposed place, and whether it was correct.
struct ScoredProposal {
  double score = 0.0;
  bool right = false;
};

/// Precision and recall when proposals from this score on are accepted.
struct PrecisionRecallPoint {
  double score = 0.0;
  double precision = 1.0;
  double recall = 0.0;
};

/// How well scores separate correct proposals from wrong ones.
struct PrecisionRecall {
  /// Descending by score; equal scores are accepted together.
  std::vector<PrecisionRecallPoint> curve;
  /// Sum of precision times gain of recall over the curve (average precision).
  double area = 0.0;
  /// Largest recall before the first wrong proposal.
  double recall_at_full_precision = 0.0;
};

/// `positives`: how many right proposals there could be; recall is relative to it. 0: everything is 0.
PrecisionRecall ComputePrecisionRecall(std::vector<ScoredProposal> proposals, int positives);

/// A frame of a sequence: its true pose, and its description.
struct PlaceFrame {
  TimedPose pose;
  PlaceDescription description;
};

/// Results of one rule to merge the scores.
struct MergeEvaluation {
  Merge merge = Merge::kAdaptive;
  /// One proposal for each frame: the best of the earlier ones, as loop detection queries. Positives: frames at a
  /// revisited place.
  PrecisionRecall best_match;
  /// Every pair is a proposal, as in the paper's similarity matrices, scored when the later frame is the newest, with
  /// the database of earlier frames only. Positives: pairs that are revisits.
  PrecisionRecall all_pairs;
};

struct PlaceEvaluation {
  std::string name;
  int frames = 0;
  int revisiting_frames = 0;
  int revisits = 0;
  int other_places = 0;
  std::vector<MergeEvaluation> merges;
  Similarities similarities;  ///< of all frames; `merged` by the default merge
};

/// Runs the frames through a recogniser in their order, once for each merge.
PlaceEvaluation EvaluatePlaces(const std::string& name, const std::vector<PlaceFrame>& frames,
                               const Vocabulary& points, const Vocabulary& lines, const RevisitOptions& options);

}  // namespace plslam::evaluate
