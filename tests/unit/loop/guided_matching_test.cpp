// SPDX-License-Identifier: BSD-3-Clause
#include "loop_process/guided_matching.h"

#include <gtest/gtest.h>

#include "core/features/matching/descriptor_matcher.h"
#include "tests/unit/mapping/mapping_world.h"
#include "tools/train_vocabulary/vocabulary_trainer.h"

namespace plslam::test {
namespace {

std::vector<Descriptor> Random(uint64_t first, int n) {
  std::vector<Descriptor> descriptors;
  for (int i = 0; i < n; ++i) descriptors.push_back(DescriptorOf(first + static_cast<uint64_t>(i)));
  return descriptors;
}

TEST(MatchByNodes, IsBruteForceWithinEachNode) {
  const Vocabulary vocabulary = train_vocabulary::TrainVocabulary({Random(0, 3000)}, FeatureType::kPoints, {});
  const std::vector<Descriptor> a = Random(0, 400);
  std::vector<Descriptor> b = Random(100, 400);
  for (size_t i = 0; i < b.size(); ++i) b[i][i % 4] ^= 0x11ULL << (i % 50);
  FeatureNodes nodes_a;
  FeatureNodes nodes_b;
  vocabulary.Transform(a, nodes_a);
  vocabulary.Transform(b, nodes_b);
  const MatchOptions options;
  const std::vector<int> matches = loop::MatchByNodes(a, nodes_a, b, nodes_b, options);
  // The slow way: each one against all of its node.
  int found = 0;
  for (size_t i = 0; i < a.size(); ++i) {
    int best = -1;
    int best_distance = options.max_distance + 1;
    for (size_t j = 0; j < b.size(); ++j) {
      if (nodes_a.node[i] != nodes_b.node[j]) continue;
      const int distance = HammingDistance(a[i], b[j]);
      if (distance < best_distance) best = static_cast<int>(j);
      best_distance = std::min(best_distance, distance);
    }
    EXPECT_EQ(matches[i], best) << i;
    found += matches[i] >= 0;
  }
  EXPECT_GT(found, 250);
}

TEST(MatchByNodes, NothingToMatch) {
  EXPECT_TRUE(loop::MatchByNodes({}, {}, Random(0, 3), {{0, 0, 0}}, {}).empty());
  EXPECT_EQ(loop::MatchByNodes(Random(0, 1), {{0}}, {}, {}, {}), std::vector<int>{-1});
}

}  // namespace
}  // namespace plslam::test
