// SPDX-License-Identifier: BSD-3-Clause
#include "core/places/place_index.h"

#include <gtest/gtest.h>

#include <map>

#include "tests/unit/places/random_places.h"

namespace plslam {
namespace {

// An index keeps 12 significant bits of a weight.
constexpr double kRelativeError = 1.0 / 4096.0;

BagOfWords RandomBag(const Vocabulary& vocabulary, int descriptors, std::mt19937_64& random) {
  return vocabulary.Transform(test::RandomDescriptors(descriptors, random));
}

TEST(PlaceIndex, ScoresEqualPairwiseSimilarity) {
  const Vocabulary vocabulary = test::SmallVocabulary(FeatureType::kPoints);
  std::mt19937_64 random(1);
  PlaceIndex index(vocabulary.words());
  std::map<int, BagOfWords> places;
  for (int step = 0; step < 300; ++step) {
    const int place = static_cast<int>(random() % 40);
    if (places.contains(place)) {
      index.Remove(place, places[place]);
      places.erase(place);
    } else {
      places[place] = RandomBag(vocabulary, static_cast<int>(random() % 60), random);
      index.Add(place, places[place]);
    }
    const BagOfWords query = RandomBag(vocabulary, 50, random);
    std::vector<float> scores(40, 0.0F);
    index.Score(query, scores);
    for (int i = 0; i < 40; ++i) {
      const double expected = places.contains(i) ? BagSimilarity(query, places[i]) : 0.0;
      ASSERT_NEAR(scores[i], expected, kRelativeError * expected) << "place " << i << " at step " << step;
    }
  }
}

TEST(PlaceIndex, WordWeightsScaleTheScores) {
  const Vocabulary vocabulary = test::SmallVocabulary(FeatureType::kPoints);
  std::mt19937_64 random(3);
  PlaceIndex index(vocabulary.words());
  std::vector<BagOfWords> bags;
  for (int i = 0; i < 30; ++i) {
    bags.push_back(RandomBag(vocabulary, 40, random));
    index.Add(i, bags.back());
  }
  index.Remove(4, bags[4]);
  bags[4] = {};
  const BagOfWords query = RandomBag(vocabulary, 50, random);
  std::vector<float> word_weights;
  for (size_t i = 0; i < query.words.size(); ++i)
    word_weights.push_back(static_cast<float>(random() % 1000) / 1000.0F);
  std::vector<float> scores(30, 0.0F);
  index.Score(query, word_weights, scores);
  std::vector<int> expected_places(query.words.size(), 0);
  for (int i = 0; i < 30; ++i) {
    const double expected = BagSimilarity(query, word_weights, bags[i]);
    EXPECT_NEAR(scores[i], expected, kRelativeError * expected) << "place " << i;
    for (size_t k = 0; k < query.words.size(); ++k) {
      for (const auto& [word, weight] : bags[i].words) expected_places[k] += word == query.words[k].first ? 1 : 0;
    }
  }
  EXPECT_EQ(index.PlacesWith(query), expected_places);
  EXPECT_EQ(index.PlacesWith({{{vocabulary.words() + 3, 1.0F}}}), std::vector<int>{0});
}

TEST(PlaceIndex, ScoresDoNotDependOnTheInsertionOrder) {
  const Vocabulary vocabulary = test::SmallVocabulary(FeatureType::kPoints);
  std::mt19937_64 random(2);
  std::vector<BagOfWords> bags;
  for (int i = 0; i < 30; ++i) bags.push_back(RandomBag(vocabulary, 40, random));
  PlaceIndex forth(vocabulary.words());
  PlaceIndex back(vocabulary.words());
  for (int i = 0; i < 30; ++i) forth.Add(i, bags[i]);
  for (int i = 29; i >= 0; --i) back.Add(i, bags[i]);
  back.Remove(7, bags[7]);
  back.Add(7, bags[7]);
  std::vector<float> a(30, 0.0F);
  std::vector<float> b(30, 0.0F);
  forth.Score(bags[3], a);
  back.Score(bags[3], b);
  EXPECT_EQ(a, b);
}

TEST(PlaceIndex, PlacesBeyondTheFirst65536) {
  const BagOfWords bag{{{0, 0.25F}, {2, 0.75F}}};
  PlaceIndex index(3);
  for (const int place : {0, 65'535, 65'536, 140'000}) index.Add(place, bag);
  index.Remove(65'535, bag);
  std::vector<float> scores(140'001, 0.0F);
  index.Score(bag, scores);
  EXPECT_EQ(scores[0], 1.0F);
  EXPECT_EQ(scores[65'535], 0.0F);
  EXPECT_EQ(scores[65'536], 1.0F);
  EXPECT_EQ(scores[140'000], 1.0F);
}

TEST(PlaceIndex, WordsBeyondTheVocabularyAreIgnored) {
  const BagOfWords bag{{{0, 0.5F}, {9, 0.5F}}};
  PlaceIndex index(3);
  index.Add(0, bag);
  std::vector<float> scores(1, 0.0F);
  index.Score(bag, scores);
  EXPECT_EQ(scores[0], 0.5F);
  index.Remove(0, bag);
  index.Remove(0, bag);
  scores[0] = 0.0F;
  index.Score(bag, scores);
  EXPECT_EQ(scores[0], 0.0F);
}

TEST(PlaceIndex, TinyAndWholeWeights) {
  PlaceIndex index(2);
  index.Add(0, {{{0, 1.0F}}});
  index.Add(1, {{{0, 1e-30F}}});
  std::vector<float> scores(2, 0.0F);
  index.Score({{{0, 1.0F}}}, scores);
  EXPECT_EQ(scores[0], 1.0F);
  EXPECT_LT(scores[1], 1e-9F);
}

}  // namespace
}  // namespace plslam
