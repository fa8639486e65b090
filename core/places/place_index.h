#pragma once

#include <cstdint>
#include <vector>

#include "core/places/bag_of_words.h"

namespace plslam {

/// Inverted index of one vocabulary: for each word the places that have it, so that a query touches only what it has in common
/// with a place. Places are small numbers, 0, 1, 2, ..., that the caller hands out.
///
/// What a query costs is reading the entries, at 10,000 places some millions. So an entry has 4 bytes: 16 of the place, 16 of
/// the weight, which keeps 12 significant bits.
class PlaceIndex {
 public:
  /// For a vocabulary of so many words; words beyond are passed over.
  explicit PlaceIndex(int words) : words_(words) {}

  /// A place must not be in the index twice. Its bag must be what it is removed with.
  void Add(int place, const BagOfWords& bag);
  void Remove(int place, const BagOfWords& bag);

  /// Adds `BagSimilarity(query, bag)` of each place, right to 1 part in 4096, to `scores[place]`. `scores` must be as long as
  /// the largest place in the index asks for. No score depends on the order in which places came and went.
  void Score(const BagOfWords& query, std::vector<float>& scores) const;
  /// The same with words that count `worth`, one for each word of the query.
  void Score(const BagOfWords& query, const std::vector<float>& worth, std::vector<float>& scores) const;

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
