#include "core/places/bag_of_words.h"

#include <algorithm>

namespace plslam {

float BagSimilarity(const BagOfWords& a, const BagOfWords& b) {
  float common = 0.0F;
  auto in_b = b.words.begin();
  for (const auto& [word, weight] : a.words) {
    while (in_b != b.words.end() && in_b->first < word) ++in_b;
    if (in_b == b.words.end()) break;
    if (in_b->first == word) common += std::min(weight, in_b->second);
  }
  return common;
}

}  // namespace plslam
