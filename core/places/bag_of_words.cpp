#include "core/places/bag_of_words.h"

#include <algorithm>

namespace plslam {

float BagSimilarity(const BagOfWords& a, const BagOfWords& b) {
  return BagSimilarity(a, std::vector<float>(a.words.size(), 1.0F), b);
}

float BagSimilarity(const BagOfWords& a, const std::vector<float>& worth, const BagOfWords& b) {
  float common = 0.0F;
  auto in_b = b.words.begin();
  for (size_t i = 0; i < a.words.size(); ++i) {
    const auto& [word, weight] = a.words[i];
    while (in_b != b.words.end() && in_b->first < word) ++in_b;
    if (in_b == b.words.end()) break;
    if (in_b->first == word) common += worth[i] * std::min(weight, in_b->second);
  }
  return common;
}

}  // namespace plslam
