// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include "core/places/options.h"
#include "core/places/place_description.h"

namespace plslam {

/// Weights of the two feature types in the score of a place, each at least 0, sum at most 1.
struct PlaceWeights {
  double points = 0.5;
  double lines = 0.5;
};

/// Returns the weights for all places compared with `query` (PL-SLAM §VI.A.1). With n features of a type and
/// dispersion d:
///
///   paper       half by n, half by d: s_t of the paper
///   strength    by n
///   dispersion  by d
///   balanced    by n, each line counted as `line_weight` points
///   adaptive    the same, with 20 additional points that no other image shares
///   points, lines   one feature type alone
///
/// Why "balanced": the similarity of two unrelated images varies more with fewer features, and lines are partly
/// redundant with points (identical doors have identical points and lines). The weights with the smallest variance for
/// unrelated images are near those of n, and lower for lines; docs/lab/places.md has the numbers.
///
/// "adaptive" adds the 20 points because the similarity of two unrelated images with few features may be large by
/// chance.
///
/// If both feature types are empty, each weight is one half, but in "adaptive" 0. Throws std::invalid_argument
/// for an unknown merge.
PlaceWeights WeightsFor(const PlaceDescription& query, const PlaceOptions& options);

/// Returns the weight of each word of a query: 1, but in "adaptive" (1 - n_i / (N + 5))^`idf_exponent`, where n_i =
/// `places_with[i]` of N = `places` have word i. A word of every door of a corridor does not identify a place, however
/// rare it was in training; the 5 additional places without words limit the effect in a small map.
std::vector<float> WordWeights(const std::vector<int>& places_with, int places, const PlaceOptions& options);

/// Inverted index of one vocabulary: for each word the places that have it, so that a query reads only the words that
/// it shares with a place. Places are numbered 0, 1, 2, ... by the caller.
///
/// The cost of a query is reading the entries, some millions at 10,000 places. An entry therefore has 4 bytes: 16 bits
/// for the place, 16 for the weight, which keeps 12 significant bits.
class PlaceIndex {
 public:
  /// `words` is the size of the vocabulary; larger words are ignored.
  explicit PlaceIndex(int words) : words_(words) {}

  /// Adds or removes a place, which must not be in the index twice. Remove it with the bag with which it was added.
  void Add(int place, const BagOfWords& bag);
  void Remove(int place, const BagOfWords& bag);

  /// Adds `BagSimilarity(query, bag)` of each place, accurate to 1 part in 4096, to `scores[place]`. The size of
  /// `scores` must exceed the largest place in the index. Scores do not depend on the order in which places were added
  /// or removed.
  void Score(const BagOfWords& query, std::vector<float>& scores) const;
  /// The same with `word_weights`, one for each word of the query.
  void Score(const BagOfWords& query, const std::vector<float>& word_weights, std::vector<float>& scores) const;

  /// Returns for each word of the query the number of places that have it.
  std::vector<int> PlacesWith(const BagOfWords& query) const;

 private:
  // Entries of each word, unordered: the place within the block in the lower half, its weight in the upper half.
  using Block = std::vector<std::vector<uint32_t>>;

  int words_;
  // One block for each 65,536 places.
  std::vector<Block> blocks_;
};

}  // namespace plslam
