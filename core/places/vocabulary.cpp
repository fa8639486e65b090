#include "core/places/vocabulary.h"

#include <algorithm>
#include <bit>

#include "core/features/image/cpu_clones.h"

namespace plslam {
namespace {

struct Fall {
  int32_t leaf = 0;
  int32_t guide = 0;
};

/// Where each descriptor ends, and which node it passes at the guide level (its leaf, where that is higher up). Equal
/// distances: the first centre.
PLSLAM_POPCNT_CLONES
void FallThrough(const Descriptor* centers, const int32_t* child_begin, const Descriptor* descriptors, size_t count,
                 int guide_level, Fall* falls) {
  for (size_t i = 0; i < count; ++i) {
    const Descriptor& d = descriptors[i];
    int32_t node = 0;
    int32_t guide = 0;
    for (int level = 1; child_begin[node] < child_begin[node + 1]; ++level) {
      const int32_t end = child_begin[node + 1];
      int nearest = 257;
      for (int32_t child = child_begin[node]; child < end; ++child) {
        const Descriptor& c = centers[child];
        const int distance = std::popcount(c[0] ^ d[0]) + std::popcount(c[1] ^ d[1]) + std::popcount(c[2] ^ d[2]) +
                             std::popcount(c[3] ^ d[3]);
        node = distance < nearest ? child : node;
        nearest = std::min(nearest, distance);
      }
      if (level <= guide_level) guide = node;
    }
    falls[i] = {node, guide};
  }
}

std::vector<Fall> FallThrough(const VocabularyTree& tree, const std::vector<Descriptor>& descriptors) {
  std::vector<Fall> falls(descriptors.size());
  FallThrough(tree.centers.data(), tree.child_begin.data(), descriptors.data(), descriptors.size(),
              Vocabulary::kGuideLevel, falls.data());
  return falls;
}

BagOfWords Count(const VocabularyTree& tree, const std::vector<Fall>& falls) {
  std::vector<int32_t> words;
  words.reserve(falls.size());
  for (const Fall& fall : falls) {
    const int32_t word = tree.word[fall.leaf];
    if (tree.idf[word] > 0.0F) words.push_back(word);
  }
  std::sort(words.begin(), words.end());
  BagOfWords bag;
  bag.words.reserve(words.size());
  double sum = 0.0;
  for (size_t i = 0; i < words.size();) {
    const size_t first = i;
    while (i < words.size() && words[i] == words[first]) ++i;
    const float weight = static_cast<float>(i - first) * tree.idf[words[first]];
    bag.words.emplace_back(words[first], weight);
    sum += weight;
  }
  for (auto& [word, weight] : bag.words) weight = static_cast<float>(weight / sum);
  return bag;
}

}  // namespace

BagOfWords Vocabulary::Transform(const std::vector<Descriptor>& descriptors) const {
  return Count(*tree_, FallThrough(*tree_, descriptors));
}

BagOfWords Vocabulary::Transform(const std::vector<Descriptor>& descriptors, FeatureNodes& nodes) const {
  const std::vector<Fall> falls = FallThrough(*tree_, descriptors);
  nodes.node.clear();
  for (const Fall& fall : falls) nodes.node.push_back(fall.guide);
  return Count(*tree_, falls);
}

}  // namespace plslam
