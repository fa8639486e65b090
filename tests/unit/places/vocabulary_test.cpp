// SPDX-License-Identifier: BSD-3-Clause
#include <chrono>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <map>
#include <numeric>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sodium.h>

#include "core/places/vocabulary.h"
#include "tests/support/data_folder.h"
#include "tests/support/text_file.h"
#include "tests/unit/places/random_places.h"

namespace plslam {
namespace {

/// Nodes from the root's child to the leaf, one level after the other.
std::vector<int> SlowPath(const VocabularyTree& tree, const Descriptor& descriptor) {
  std::vector<int> path{0};
  while (tree.child_begin[path.back()] != tree.child_begin[path.back() + 1]) {
    int best = tree.child_begin[path.back()];
    for (int child = best; child < tree.child_begin[path.back() + 1]; ++child) {
      if (HammingDistance(descriptor, tree.centers[child]) < HammingDistance(descriptor, tree.centers[best])) {
        best = child;
      }
    }
    path.push_back(best);
  }
  return path;
}

std::map<int, double> SlowBag(const VocabularyTree& tree, const std::vector<Descriptor>& descriptors) {
  std::map<int, double> weight;
  double sum = 0.0;
  for (const Descriptor& d : descriptors) {
    const int word = tree.word[SlowPath(tree, d).back()];
    weight[word] += tree.idf[word];
    sum += tree.idf[word];
  }
  std::erase_if(weight, [](const auto& entry) { return entry.second == 0.0; });
  for (auto& [word, w] : weight) w /= sum;
  return weight;
}

TEST(Vocabulary, WordsAndNodesEqualTheSlowWay) {
  const Vocabulary vocabulary = test::SmallVocabulary(FeatureType::kPoints);
  EXPECT_GT(vocabulary.words(), 100);
  std::mt19937_64 random(7);
  for (int i = 0; i < 20; ++i) {
    const std::vector<Descriptor> descriptors = test::RandomDescriptors(50, random);
    FeatureNodes nodes;
    const BagOfWords bag = vocabulary.Transform(descriptors, nodes);
    EXPECT_EQ(bag, vocabulary.Transform(descriptors));
    const std::map<int, double> slow = SlowBag(vocabulary.tree(), descriptors);
    ASSERT_EQ(bag.words.size(), slow.size());
    auto expected = slow.begin();
    for (const auto& [word, weight] : bag.words) {
      EXPECT_EQ(word, expected->first);
      EXPECT_NEAR(weight, expected->second, 1e-6);
      ++expected;
    }
    for (size_t k = 0; k < descriptors.size(); ++k) {
      const std::vector<int> path = SlowPath(vocabulary.tree(), descriptors[k]);
      EXPECT_EQ(nodes.node[k], path[std::min<size_t>(Vocabulary::kGuideLevel, path.size() - 1)]);
    }
  }
}

TEST(Vocabulary, WithoutDescriptorsThereAreNoWords) {
  const Vocabulary vocabulary = test::SmallVocabulary(FeatureType::kPoints);
  FeatureNodes nodes{{1, 2}};
  EXPECT_TRUE(vocabulary.Transform({}, nodes).words.empty());
  EXPECT_TRUE(nodes.node.empty());
}

TEST(Vocabulary, OneDescriptorIsOneWordOfWeightOne) {
  std::mt19937_64 random(8);
  const BagOfWords bag = test::SmallVocabulary(FeatureType::kLines).Transform({test::RandomDescriptor(random)});
  ASSERT_EQ(bag.words.size(), 1U);
  EXPECT_EQ(bag.words[0].second, 1.0F);
}

TEST(Training, IsTheSameAtEveryRunAndAnotherWithAnotherSeed) {
  const Vocabulary a = test::SmallVocabulary(FeatureType::kPoints);
  EXPECT_EQ(a.checksum(), test::SmallVocabulary(FeatureType::kPoints).checksum());
  EXPECT_NE(a.checksum(), test::SmallVocabulary(FeatureType::kLines).checksum());
  std::mt19937_64 random(5);
  const auto images = test::RandomImages(40, 60, random);
  train_vocabulary::TrainingOptions options;
  const Vocabulary first = train_vocabulary::TrainVocabulary(images, FeatureType::kPoints, options);
  options.seed = 2;
  EXPECT_NE(first.checksum(), train_vocabulary::TrainVocabulary(images, FeatureType::kPoints, options).checksum());
}

TEST(Training, WeightsAreInverseDocumentFrequencies) {
  std::mt19937_64 random(9);
  const auto images = test::RandomImages(30, 40, random);
  train_vocabulary::TrainingOptions options;
  options.branching = 4;
  options.depth = 2;
  const Vocabulary vocabulary = train_vocabulary::TrainVocabulary(images, FeatureType::kPoints, options);
  std::vector<int> with_word(vocabulary.words(), 0);
  for (const auto& image : images) {
    std::map<int, bool> has;
    for (const Descriptor& d : image) has[vocabulary.tree().word[SlowPath(vocabulary.tree(), d).back()]] = true;
    for (const auto& [word, yes] : has) ++with_word[word];
  }
  for (int word = 0; word < vocabulary.words(); ++word) {
    EXPECT_NEAR(vocabulary.tree().idf[word], std::log(30.0 / with_word[word]), 1e-6) << "word " << word;
  }
}

TEST(Training, WordsThatAllImagesHaveAreLeftOut) {
  std::mt19937_64 random(10);
  const std::vector<Descriptor> two = test::RandomDescriptors(2, random);
  train_vocabulary::TrainingOptions options;
  options.min_descriptors = 2;
  const Vocabulary vocabulary =
      train_vocabulary::TrainVocabulary({{two[0], two[1]}, {two[0]}}, FeatureType::kPoints, options);
  EXPECT_EQ(vocabulary.words(), 2);
  EXPECT_TRUE(vocabulary.Transform({two[0], two[0]}).words.empty());
  EXPECT_EQ(vocabulary.Transform({two[1]}).words.size(), 1U);
}

TEST(Training, NoOrEqualDescriptorsGiveOneWeightlessWord) {
  std::mt19937_64 random(11);
  const Descriptor descriptor = test::RandomDescriptor(random);
  const std::vector<std::vector<Descriptor>> equal(3, std::vector<Descriptor>(100, descriptor));
  for (const auto& images : {std::vector<std::vector<Descriptor>>{}, {{}, {}}, equal}) {
    const Vocabulary vocabulary =
        train_vocabulary::TrainVocabulary(images, FeatureType::kLines, train_vocabulary::TrainingOptions{});
    EXPECT_EQ(vocabulary.words(), 1);
    EXPECT_TRUE(vocabulary.Transform({descriptor}).words.empty());
  }
}

TEST(Training, ProgressRisesToTheEnd) {
  std::mt19937_64 random(12);
  double last = 0.0;
  train_vocabulary::TrainVocabulary(test::RandomImages(20, 50, random), FeatureType::kPoints,
                                    train_vocabulary::TrainingOptions{}, [&](double share) {
                                      EXPECT_GE(share, last);
                                      EXPECT_LE(share, 1.0);
                                      last = share;
                                    });
  EXPECT_GT(last, 0.99);
}

TEST(BagOfWords, SimilarityIsOneMinusHalfTheDistance) {
  const Vocabulary vocabulary = test::SmallVocabulary(FeatureType::kPoints);
  std::mt19937_64 random(13);
  for (int i = 0; i < 20; ++i) {
    const BagOfWords a = vocabulary.Transform(test::RandomDescriptors(80, random));
    const BagOfWords b = vocabulary.Transform(test::RandomDescriptors(30, random));
    std::map<int, double> difference;
    for (const auto& [word, weight] : a.words) difference[word] += weight;
    for (const auto& [word, weight] : b.words) difference[word] -= weight;
    double distance = 0.0;
    for (const auto& [word, d] : difference) distance += std::abs(d);
    EXPECT_NEAR(BagSimilarity(a, b), 1.0 - 0.5 * distance, 1e-5);
    EXPECT_EQ(BagSimilarity(a, b), BagSimilarity(b, a));
    EXPECT_NEAR(BagSimilarity(a, a), 1.0, 1e-5);
  }
}

TEST(BagOfWords, NothingInCommonIsZero) {
  EXPECT_EQ(BagSimilarity({}, {}), 0.0F);
  EXPECT_EQ(BagSimilarity({{{1, 1.0F}}}, {}), 0.0F);
  EXPECT_EQ(BagSimilarity({{{1, 0.5F}, {5, 0.5F}}}, {{{2, 0.5F}, {7, 0.5F}}}), 0.0F);
}

}  // namespace

namespace {

using testing::HasSubstr;

std::string Objection(const std::string& bytes) {
  try {
    Vocabulary::FromBytes(bytes, "v");
  } catch (const std::runtime_error& e) {
    return e.what();
  }
  return "";
}

/// Returns the bytes with a valid checksum, as a faulty writer or an attacker would make them.
std::string Signed(std::string bytes) {
  const size_t content = bytes.size() - 32;
  crypto_generichash(reinterpret_cast<unsigned char*>(&bytes[content]), 32,
                     reinterpret_cast<const unsigned char*>(bytes.data()), content, nullptr, 0);
  return bytes;
}

template <class T>
std::string With(std::string bytes, size_t at, T value) {
  std::memcpy(&bytes.at(at), &value, sizeof(T));
  return bytes;
}

TEST(VocabularyFile, RoundTripKeepsEveryByteAndWord) {
  const ScratchFolder folder;
  const Vocabulary vocabulary = test::SmallVocabulary(FeatureType::kLines);
  vocabulary.Save(folder.Path("a"));
  const Vocabulary again = Vocabulary::Load(folder.Path("a"));
  again.Save(folder.Path("b"));
  EXPECT_EQ(ReadText(folder.Path("a")), ReadText(folder.Path("b")));
  EXPECT_EQ(ReadText(folder.Path("a")), vocabulary.ToBytes());
  EXPECT_EQ(again.checksum(), vocabulary.checksum());
  EXPECT_EQ(again.checksum().size(), 64U);
  EXPECT_EQ(again.type(), FeatureType::kLines);
  EXPECT_EQ(again.tree().images, 40);
  std::mt19937_64 random(1);
  const auto descriptors = test::RandomDescriptors(100, random);
  EXPECT_EQ(again.Transform(descriptors), vocabulary.Transform(descriptors));
}

TEST(VocabularyFile, OtherAndDamagedFilesAreRefused) {
  const std::string good = test::SmallVocabulary(FeatureType::kPoints).ToBytes();
  EXPECT_THAT(Objection(""), HasSubstr("vocabulary v is not a vocabulary of this program"));
  EXPECT_THAT(Objection("%YAML:1.0\n"), HasSubstr("is not a vocabulary of this program"));
  EXPECT_THAT(Objection(good.substr(0, 20)), HasSubstr("is truncated"));
  EXPECT_THAT(Objection(good.substr(0, 1000)), HasSubstr("has 1000 bytes, but its header states"));
  EXPECT_THAT(Objection(good + "x"), HasSubstr("but its header states"));
  EXPECT_THAT(Objection(With<uint32_t>(good, 8, 7)),
              HasSubstr("has format version 7, and this program reads version"));
  EXPECT_THAT(Objection(With<uint32_t>(good, 24, 0)), HasSubstr("is damaged: 0 nodes"));
  EXPECT_THAT(Objection(With<uint32_t>(good, 24, 4'000'000'000)), HasSubstr("is damaged: 4000000000 nodes"));
  std::string flipped = good;
  flipped[good.size() / 2] ^= 4;
  EXPECT_THAT(Objection(flipped), HasSubstr("its checksum is wrong"));
  EXPECT_EQ(Objection(good), "");
}

TEST(VocabularyFile, DamagedContentWithAValidChecksumIsRefused) {
  const std::string good = test::SmallVocabulary(FeatureType::kPoints).ToBytes();
  EXPECT_THAT(Objection(Signed(With<uint32_t>(good, 12, 2))), HasSubstr("type"));
  EXPECT_THAT(Objection(Signed(With<uint8_t>(good, 32, 1))), HasSubstr("node 0 has 1 children"));
  EXPECT_THAT(Objection(Signed(With<uint8_t>(good, 32, 200))), HasSubstr("node 0 has 200 children"));
  EXPECT_THAT(Objection(Signed(With<uint8_t>(good, 32, 0))), HasSubstr("has no parent"));
  EXPECT_THAT(Objection(Signed(With<uint8_t>(good, 33, 60))), HasSubstr("missing"));
  EXPECT_THAT(Objection(Signed(With<float>(good, good.size() - 36, -1.0F))), HasSubstr("a word has the weight -1"));
  EXPECT_THAT(Objection(Signed(With<float>(good, good.size() - 36, NAN))), HasSubstr("a word has the weight nan"));
}

TEST(VocabularyFile, MissingFilesAndFoldersAreNamed) {
  const ScratchFolder folder;
  const auto objection = [](const std::string& path) -> std::string {
    try {
      Vocabulary::Load(path);
    } catch (const std::runtime_error& e) {
      return e.what();
    }
    return "";
  };
  EXPECT_THAT(objection(folder.Path("none")), HasSubstr("none cannot be read"));
  EXPECT_THAT(objection(folder.Path("")), HasSubstr("vocabulary " + folder.Path("")));
  EXPECT_THROW(test::SmallVocabulary(FeatureType::kPoints).Save(folder.Path("no/folder")), std::runtime_error);
}

TEST(DefaultVocabularies, AreSmallAndLoadFast) {
  const auto config = test::SourceFolder() / "config";
  EXPECT_LE(
      std::filesystem::file_size(config / "orb.vocabulary") + std::filesystem::file_size(config / "lbd.vocabulary"),
      8'000'000U);
  double best_s = 1e9;
  for (int i = 0; i < 3; ++i) {
    const auto start = std::chrono::steady_clock::now();
    const Vocabulary points = Vocabulary::Load(config / "orb.vocabulary");
    const Vocabulary lines = Vocabulary::Load(config / "lbd.vocabulary");
    best_s = std::min(best_s, std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
    EXPECT_EQ(points.type(), FeatureType::kPoints);
    EXPECT_EQ(lines.type(), FeatureType::kLines);
    EXPECT_GT(points.words(), 50'000);
    EXPECT_GT(lines.words(), 5'000);
  }
  EXPECT_LT(best_s, 0.2);
}

}  // namespace
}  // namespace plslam
