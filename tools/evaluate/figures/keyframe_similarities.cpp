// SPDX-License-Identifier: BSD-3-Clause
#include "tools/evaluate/figures/keyframe_similarities.h"

#include <algorithm>
#include <vector>

namespace plslam {

KeyframeSimilarities SimilaritiesOf(const StoredMap& stored, const PlaceRecogniser& recogniser, int most) {
  KeyframeSimilarities result;
  const int n = static_cast<int>(stored.features.size());
  result.step = std::max(1, (n + most - 1) / most);
  std::vector<PlaceDescription> places;
  int i = 0;
  for (const auto& [id, features] : stored.features) {
    if (i++ % result.step == 0) places.push_back(recogniser.Describe(features));
  }
  const int size = static_cast<int>(places.size());
  for (SimilarityMatrix* matrix : {&result.points, &result.lines, &result.merged}) matrix->size = size;
  for (const PlaceDescription& row : places) {
    for (const PlaceDescription& column : places) {
      const PlaceMatch match = recogniser.Compare(row, column);
      result.points.values.push_back(static_cast<float>(match.score_points));
      result.lines.values.push_back(static_cast<float>(match.score_lines));
      result.merged.values.push_back(static_cast<float>(match.score));
    }
  }
  return result;
}

}  // namespace plslam
