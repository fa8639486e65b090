// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include "core/places/options.h"
#include "core/places/place_description.h"

namespace plslam {

/// Weights of the two kinds in the score of a place, each at least 0, sum at most 1.
struct PlaceWeights {
  double points = 0.5;
  double lines = 0.5;
};

/// Weights for all places that are compared with `query` (PL-SLAM §VI.A.1). With n features of a type and dispersion
/// d:
///
///   paper       half by n, half by d: s_t of the paper
///   strength    by n
///   dispersion  by d
///   balanced    by n, each line counted as `line_weight` points
///   adaptive    the same, with 20 points more that no other image shares
///   points, lines   one feature type alone
///
/// Why "balanced": the similarity of two unrelated images spreads the more the fewer features it is made of, and what
/// lines add is in part what points have said already (identical doors are identical in both). The weights with the
/// smallest spread for unrelated images are near those of n, and lower for lines; docs/lab/places.md has the numbers.
///
/// "adaptive" has the 20 because the similarity of two unrelated images is large by chance where few features make it
/// up.
///
/// A share of nothing in nothing is one half. Throws std::invalid_argument for an unknown merge.
PlaceWeights WeightsFor(const PlaceDescription& query, const PlaceOptions& options);

/// What each word of a query counts: 1, but in "adaptive" the power `idf_exponent` of the share of places without it.
/// What every door of a corridor has says nothing there about where one is, however rare it was in training.
/// `places_with[i]` of `places` have word i; five more without any word keep a small map from judging.
std::vector<float> WordWeights(const std::vector<int>& places_with, int places, const PlaceOptions& options);

/// Inverted index of one vocabulary: for each word the places that have it, so that a query touches only what it has
/// in common with a place. Places are small numbers, 0, 1, 2, ..., that the caller hands out.
///
/// What a query costs is reading the entries, at 10,000 places some millions. So an entry has 4 bytes: 16 of the
/// place, 16 of the weight, which keeps 12 significant bits.
class PlaceIndex {
 public:
  /// For a vocabulary of so many words; words beyond are passed over.
  explicit PlaceIndex(int words) : words_(words) {}

  /// A place must not be in the index twice. Its bag must be what it is removed with.
  void Add(int place, const BagOfWords& bag);
  void Remove(int place, const BagOfWords& bag);

  /// Adds `BagSimilarity(query, bag)` of each place, right to 1 part in 4096, to `scores[place]`. `scores` must be as
  /// long as the largest place in the index asks for. No score depends on the order in which places came and went.
  void Score(const BagOfWords& query, std::vector<float>& scores) const;
  /// The same with words that count `worth`, one for each word of the query.
  void Score(const BagOfWords& query, const std::vector<float>& word_weights, std::vector<float>& scores) const;

  /// How many places have each word of the query.
  std::vector<int> PlacesWith(const BagOfWords& query) const;

 private:
  // Entries of each word, without order: the place within the block in the lower half, its weight in the upper half.
  using Block = std::vector<std::vector<uint32_t>>;

  int words_;
  // One for each 65,536 places.
  std::vector<Block> blocks_;
};

}  // namespace plslam
