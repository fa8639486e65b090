// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <vector>

#include "core/features/features.h"
#include "core/ids/ids.h"
#include "core/places/options.h"
#include "core/places/place_description.h"
#include "core/places/place_index.h"
#include "core/places/vocabulary.h"

namespace plslam {

/// A keyframe similar to the query.
struct PlaceMatch {
  KeyframeId keyframe_id = 0;
  /// Score of the configured merge of `score_points` and `score_lines`, the weighted similarities, 0 to 1.
  double score = 0.0;
  double score_points = 0.0;
  double score_lines = 0.0;
};

/// Recognises places by points and lines together (PL-SLAM §VI.A.1): a vocabulary and an inverted index for each
/// feature type, and one score merged from both: w_points * score_points + w_lines * score_lines (`WeightsFor`). A
/// value; no thread inside, const calls may run in parallel.
class PlaceRecogniser {
 public:
  /// Throws std::invalid_argument if a vocabulary is of the other type, or the merge is unknown.
  PlaceRecogniser(Vocabulary points, Vocabulary lines, const PlaceOptions& options);

  const Vocabulary& point_vocabulary() const { return points_; }
  const Vocabulary& line_vocabulary() const { return lines_; }

  PlaceDescription Describe(const FeaturesView& features) const;
  PlaceDescription Describe(const ImageFeatures& features) const;

  /// Adds a keyframe, or replaces its description.
  void Add(KeyframeId keyframe_id, PlaceDescription description);
  /// Returns whether the keyframe was present.
  bool Remove(KeyframeId keyframe_id);
  bool Has(KeyframeId keyframe_id) const { return place_of_.contains(keyframe_id); }
  /// Throws std::out_of_range if the keyframe is not present.
  const PlaceDescription& Of(KeyframeId keyframe_id) const;
  int size() const { return static_cast<int>(place_of_.size()); }

  /// Returns the keyframes most similar to `query`, best first, equal scores by id; at most `max_results`, none with
  /// score 0, none for which `excluded` (may be empty) returns true. `excluded` is called for the best ones only.
  std::vector<PlaceMatch> Query(const PlaceDescription& query, const std::function<bool(KeyframeId)>& excluded,
                                int max_results) const;

  /// Returns the score of `other`, which need not be a keyframe, for the query `query`; the scores of `Query` are
  /// accurate to 1 part in 4096 of it. In the merge "adaptive" scores depend on the keyframes present.
  PlaceMatch Compare(const PlaceDescription& query, const PlaceDescription& other) const;
  double Score(const PlaceDescription& query, const PlaceDescription& other) const;

 private:
  int FreePlace();
  std::vector<float> Weights(const PlaceIndex& index, const BagOfWords& query) const;

  Vocabulary points_;
  Vocabulary lines_;
  PlaceOptions options_;
  PlaceIndex point_index_;
  PlaceIndex line_index_;
  // By place; separate, because a query reads all ids and few descriptions.
  std::vector<KeyframeId> keyframe_ids_;
  std::vector<PlaceDescription> descriptions_;
  // Places freed by Remove, reused in reverse order.
  std::vector<int> free_;
  std::map<KeyframeId, int> place_of_;
};

}  // namespace plslam
