// Mutates vocabularies: bytes that are one are used, all others refused with a sentence, within a bound of memory. Half of the
// cases get a checksum that fits, so that what lies behind it is reached.
//
// PLSLAM_FUZZ_SECONDS sets the duration (default 2), PLSLAM_FUZZ_SEED the first seed (default 1). Each case is made from
// its seed alone, which a failure names.
#include <gtest/gtest.h>
#include <sodium.h>

#include <chrono>
#include <cmath>
#include <cstdlib>

#include "core/places/vocabulary.h"
#include "tests/unit/bus/allocation_counter.h"
#include "tests/unit/places/random_places.h"

namespace plslam {
namespace {

double EnvironmentNumber(const char* name, double fallback) {
  const char* text = std::getenv(name);
  return text == nullptr ? fallback : std::atof(text);
}

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

/// What any vocabulary must keep to, whatever its content.
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

TEST(VocabularyFuzz, MutatedVocabulariesAreSoundOrRefused) {
  using Clock = std::chrono::steady_clock;
  const std::string good = test::SmallVocabulary(WordKind::kPoints).ToBytes();
  const auto end = Clock::now() + std::chrono::duration<double>(EnvironmentNumber("PLSLAM_FUZZ_SECONDS", 2.0));
  const auto first = static_cast<uint64_t>(EnvironmentNumber("PLSLAM_FUZZ_SEED", 1.0));
  uint64_t seed = first;
  int accepted = 0;
  for (; Clock::now() < end && !HasFailure(); ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::mt19937_64 random(seed);
    std::string bytes = good;
    Mutate(bytes, random);
    if (random() % 2 == 0) Sign(bytes);
    bus::test::allocated = 0;
    try {
      const Vocabulary vocabulary = Vocabulary::FromBytes(bytes, "mutated");
      ASSERT_LE(bus::test::allocated, 20 * bytes.size() + 10'000);
      ASSERT_EQ(vocabulary.ToBytes(), bytes);
      Use(vocabulary, random);
      ++accepted;
    } catch (const std::runtime_error& error) {
      ASSERT_LE(bus::test::allocated, 20 * bytes.size() + 10'000) << error.what();
      ASSERT_EQ(std::string(error.what()).find("vocabulary mutated "), 0U) << error.what();
    }
  }
  std::printf("  %lu cases, %d accepted\n", static_cast<unsigned long>(seed - first), accepted);
  EXPECT_GT(accepted, 0);
}

}  // namespace
}  // namespace plslam
