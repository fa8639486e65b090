// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

namespace plslam {

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

}  // namespace plslam
