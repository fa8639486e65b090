#pragma once

#include <cstdint>
#include <vector>

#include "core/places/bag_of_words.h"

namespace plslam {

/// Inverted index of one vocabulary: for each word the places that have it, so that a query touches only what it has in common
/// with a place. Places are small numbers that the caller hands out.
class PlaceIndex {
 public:
  /// For a vocabulary of so many words; words beyond are passed over.
  explicit PlaceIndex(int words) : places_of_word_(words) {}

  /// A place must not be in the index twice. Its bag must be what it is removed with.
  void Add(int place, const BagOfWords& bag);
  void Remove(int place, const BagOfWords& bag);

  /// Adds `Similarity(query, bag)` of each place to `scores[place]`, to the last bit where that was 0.
  void Score(const BagOfWords& query, std::vector<float>& scores) const;

 private:
  struct Entry {
    int32_t place;
    float weight;
  };
  // The entries of a word have no order: no score depends on it.
  std::vector<std::vector<Entry>> places_of_word_;
};

}  // namespace plslam
