// SPDX-License-Identifier: BSD-3-Clause
#include <gmock/gmock.h>
#include <sodium.h>

#include <chrono>
#include <cstring>
#include <filesystem>

#include "core/places/vocabulary.h"
#include "tests/support/data_folder.h"
#include "tests/support/text_file.h"
#include "tests/unit/places/random_places.h"

namespace plslam {
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

/// The bytes with a checksum that fits them: what a writer with an error, or an enemy, would make.
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

TEST(VocabularyFile, WhatIsNoVocabularyIsRefusedInOneSentence) {
  const std::string good = test::SmallVocabulary(FeatureType::kPoints).ToBytes();
  EXPECT_THAT(Objection(""), HasSubstr("vocabulary v is no vocabulary of this program"));
  EXPECT_THAT(Objection("%YAML:1.0\n"), HasSubstr("is no vocabulary of this program"));
  EXPECT_THAT(Objection(good.substr(0, 20)), HasSubstr("is truncated"));
  EXPECT_THAT(Objection(good.substr(0, 1000)), HasSubstr("has 1000 bytes where its header asks for"));
  EXPECT_THAT(Objection(good + "x"), HasSubstr("where its header asks for"));
  EXPECT_THAT(Objection(With<uint32_t>(good, 8, 7)),
              HasSubstr("has format version 7, and this program reads version"));
  EXPECT_THAT(Objection(With<uint32_t>(good, 24, 0)), HasSubstr("is damaged: 0 nodes"));
  EXPECT_THAT(Objection(With<uint32_t>(good, 24, 4'000'000'000)), HasSubstr("is damaged: 4000000000 nodes"));
  std::string flipped = good;
  flipped[good.size() / 2] ^= 4;
  EXPECT_THAT(Objection(flipped), HasSubstr("its checksum does not fit"));
  EXPECT_EQ(Objection(good), "");
}

TEST(VocabularyFile, NonsenseWithAFittingChecksumIsRefused) {
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
