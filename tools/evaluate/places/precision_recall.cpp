// SPDX-License-Identifier: BSD-3-Clause
#include "tools/evaluate/places/precision_recall.h"

#include <algorithm>

namespace plslam {

PrecisionRecall ComputePrecisionRecall(std::vector<ScoredProposal> proposals, int positives) {
  PrecisionRecall result;
  if (positives <= 0) return result;
  std::sort(proposals.begin(), proposals.end(), [](const auto& a, const auto& b) { return a.score > b.score; });
  int right = 0;
  int wrong = 0;
  double recall_before = 0.0;
  for (size_t i = 0; i < proposals.size();) {
    const double score = proposals[i].score;
    for (; i < proposals.size() && proposals[i].score == score; ++i) ++(proposals[i].right ? right : wrong);
    const double precision = 1.0 * right / (right + wrong);
    const double recall = 1.0 * right / positives;
    result.curve.push_back({score, precision, recall});
    result.area += precision * (recall - recall_before);
    recall_before = recall;
    if (wrong == 0) result.recall_at_full_precision = recall;
  }
  return result;
}

}  // namespace plslam
