// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <vector>

#include "core/features/features.h"
#include "core/places/options.h"
#include "core/places/place_description.h"
#include "core/places/place_index.h"
#include "core/places/vocabulary.h"

namespace plslam {

/// A keyframe that looks like the query.
struct PlaceMatch {
  int64_t keyframe_id = 0;
  /// By the merge of the options, of `score_points` and `score_lines`, the similarities with words as they count in
  /// it, 0 to 1.
  double score = 0.0;
  double score_points = 0.0;
  double score_lines = 0.0;
};

/// Recognises places by points and lines together (PL-SLAM §VI.A.1): a vocabulary and an inverted index for each
/// feature type, both asked at every query, and one score merged from the two. A value; no thread inside, const calls
/// may run side by side.
class PlaceRecogniser {
 public:
  /// Throws std::invalid_argument where a vocabulary is of the other type, or the merge is unknown.
  PlaceRecogniser(Vocabulary points, Vocabulary lines, const PlaceOptions& options);

  const Vocabulary& point_vocabulary() const { return points_; }
  const Vocabulary& line_vocabulary() const { return lines_; }

  PlaceDescription Describe(const FeaturesView& features) const;
  PlaceDescription Describe(const ImageFeatures& features) const;

  /// A keyframe that is there already is replaced.
  void Add(int64_t keyframe_id, PlaceDescription description);
  /// Whether it was there.
  bool Remove(int64_t keyframe_id);
  bool Has(int64_t keyframe_id) const { return place_of_.contains(keyframe_id); }
  /// Throws std::out_of_range where it is not there.
  const PlaceDescription& Of(int64_t keyframe_id) const;
  int size() const { return static_cast<int>(place_of_.size()); }

  /// The keyframes most like `query`, best first, equal scores by id; at most `max_results`, none of score 0, none
  /// that `excluded` (may be empty) says yes to. It is asked about the best ones only.
  std::vector<PlaceMatch> Query(const PlaceDescription& query, const std::function<bool(int64_t)>& excluded,
                                int max_results) const;

  /// The score that a query for `query` gives to `other`, which need not be one of the keyframes; a query is right to
  /// 1 part in 4096 of it. In the merge "adaptive" scores depend on the keyframes that are there.
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
  // Of each place; apart, because a query reads all ids and few descriptions.
  std::vector<int64_t> keyframe_ids_;
  std::vector<PlaceDescription> descriptions_;
  // Places that Remove has emptied, to be used again, the last first.
  std::vector<int> free_;
  std::map<int64_t, int> place_of_;
};

}  // namespace plslam
