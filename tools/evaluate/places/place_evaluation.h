// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/geometry/se3.h"
#include "core/places/place_recogniser.h"
#include "tools/evaluate/places/similarity_figure.h"

namespace plslam::evaluate {

/// What counts as the same place. Between a revisit and another place lie pairs whose views overlap in part: neither
/// right nor wrong.
struct RevisitOptions {
  /// A revisit is at most this far away, in position and in direction of view.
  double distance_m = 1.0;
  double angle_deg = 30.0;
  /// Another place is farther away than one of these.
  double far_distance_m = 5.0;
  double far_angle_deg = 90.0;
  /// Pairs that follow each other sooner are no revisit and not looked at.
  double min_gap_s = 5.0;
};

enum class PairTruth { kIgnored, kRevisit, kOtherPlace };

/// A true pose of the camera.
struct TimedPose {
  int64_t t_ns = 0;
  SE3 T_w_c;
};

PairTruth ClassifyPair(const TimedPose& a, const TimedPose& b, const RevisitOptions& options);

/// A place that was proposed, and whether it was the right one.
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

/// How well scores tell right proposals from wrong ones.
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

struct PlaceEvaluation {
  std::string name;
  int frames = 0;
  int revisiting_frames = 0;
  int revisits = 0;
  int other_places = 0;
  std::vector<MergeEvaluation> merges;
  Similarities similarities;  ///< of all frames; `merged` by the default merge
};

/// Names of all merges, the default first.
std::vector<std::string> MergeNames();

/// Runs the frames through a recogniser in their order, once for each merge.
PlaceEvaluation EvaluatePlaces(const std::string& name, const std::vector<PlaceFrame>& frames,
                               const Vocabulary& points, const Vocabulary& lines, const RevisitOptions& options);

}  // namespace plslam::evaluate
