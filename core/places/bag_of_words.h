#pragma once

#include <cstdint>
#include <utility>
#include <vector>

namespace plslam {

/// An image as the words of a vocabulary that it contains (PL-SLAM §VI.A.1).
struct BagOfWords {
  /// (word, weight), ascending by word; TF-IDF weights above 0 that sum to 1. Empty where the image has no known word.
  std::vector<std::pair<int32_t, float>> words;

  bool operator==(const BagOfWords&) const = default;
};

/// 1 - |a - b|_1 / 2 (Galvez-Lopez and Tardos, T-RO 2012), which for weights that sum to 1 is the weight that the two have
/// in common: 0 without a common word, 1 for equal bags, symmetric.
float BagSimilarity(const BagOfWords& a, const BagOfWords& b);

/// The same where the common weight of the i-th word of `a` counts `worth[i]`: at most 1, and symmetric no more.
float BagSimilarity(const BagOfWords& a, const std::vector<float>& worth, const BagOfWords& b);

}  // namespace plslam
