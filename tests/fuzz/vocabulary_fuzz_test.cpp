// SPDX-License-Identifier: BSD-3-Clause
// Mutates vocabularies: valid bytes are used, all others rejected with a sentence, within a bound of memory. Half of
// the cases get a valid checksum, so that the content after it is reached.
#include <gtest/gtest.h>
#include <sodium.h>

#include <cmath>

#include "core/places/vocabulary.h"
#include "tests/support/fuzzing.h"
#include "tests/unit/bus/allocation_counter.h"
#include "tests/unit/places/random_places.h"

namespace plslam {
namespace {

/// Mostly in the header and the shape of the tree, where a byte matters.
size_t SomePlace(const std::string& bytes, std::mt19937_64& random) {
  const size_t area = random() % 4 == 0 ? bytes.size() : std::min<size_t>(bytes.size(), 32 + 300);
  return random() % area;
}

void Mutate(std::string& bytes, std::mt19937_64& random) {
  for (uint64_t n = 1 + random() % 4; n > 0 && bytes.size() > 1; --n) {
    const size_t at = SomePlace(bytes, random);
    switch (random() % 6) {
      case 0:
        bytes[at] = static_cast<char>(bytes[at] ^ (1 << (random() % 8)));
        break;
      case 1:
        bytes[at] = static_cast<char>(random());
        break;
      case 2:
        bytes.insert(at, random() % 40, static_cast<char>(random()));
        break;
      case 3:
        bytes.erase(at, random() % 40);
        break;
      case 4:
        for (size_t i = at; i < std::min(at + 4, bytes.size()); ++i) bytes[i] = random() % 2 == 0 ? '\xFF' : '\x7F';
        break;
      default:
        if (random() % 4 == 0) bytes.resize(at);
    }
  }
}

void Sign(std::string& bytes) {
  if (bytes.size() < 32) return;
  const size_t content = bytes.size() - 32;
  crypto_generichash(reinterpret_cast<unsigned char*>(&bytes[content]), 32,
                     reinterpret_cast<const unsigned char*>(bytes.data()), content, nullptr, 0);
}

/// Checks the invariants of any vocabulary, whatever its content.
void Use(const Vocabulary& vocabulary, std::mt19937_64& random) {
  FeatureNodes nodes;
  const BagOfWords bag = vocabulary.Transform(test::RandomDescriptors(20, random), nodes);
  float sum = 0.0F;
  for (const auto& [word, weight] : bag.words) {
    ASSERT_TRUE(word >= 0 && word < vocabulary.words());
    ASSERT_TRUE(std::isfinite(weight) && weight >= 0.0F) << weight;
    sum += weight;
  }
  ASSERT_TRUE(bag.words.empty() || std::abs(sum - 1.0F) < 1e-4F) << sum;
  for (const int32_t node : nodes.node) ASSERT_TRUE(node >= 0 && node < vocabulary.tree().nodes());
}

/// Returns true if the bytes are accepted.
bool IsSoundOrRefused(const std::string& bytes, std::mt19937_64& random) {
  bus::test::allocated = 0;
  try {
    const Vocabulary vocabulary = Vocabulary::FromBytes(bytes, "mutated");
    EXPECT_LE(bus::test::allocated, 20 * bytes.size() + 10'000);
    EXPECT_EQ(vocabulary.ToBytes(), bytes);
    Use(vocabulary, random);
    return true;
  } catch (const std::runtime_error& error) {
    EXPECT_LE(bus::test::allocated, 20 * bytes.size() + 10'000) << error.what();
    EXPECT_EQ(std::string(error.what()).find("vocabulary mutated "), 0U) << error.what();
    return false;
  }
}

TEST(VocabularyFuzz, MutatedVocabulariesAreSoundOrRefused) {
  const std::string good = test::SmallVocabulary(FeatureType::kPoints).ToBytes();
  const test::FuzzCounts counts = test::Fuzz([&](std::mt19937_64& random) {
    std::string bytes = good;
    Mutate(bytes, random);
    if (random() % 2 == 0) Sign(bytes);
    return IsSoundOrRefused(bytes, random);
  });
  EXPECT_GT(counts.accepted, 0U);
}

}  // namespace
}  // namespace plslam
