// SPDX-License-Identifier: BSD-3-Clause
#include "core/places/place_index.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <stdexcept>

namespace plslam {
namespace {

// Points added to each image in the adaptive merge.
constexpr double kUnsharedPoints = 20.0;
// Places without words added to the map in the adaptive merge.
constexpr double kPlacesWithoutWords = 5.0;

double Share(double part, double other) { return part + other > 0.0 ? part / (part + other) : 0.5; }

double WeightOfPoints(const PlaceDescription& query, const PlaceOptions& options) {
  const double strength = Share(query.n_points, query.n_lines);
  const double dispersion = Share(query.dispersion_points_px, query.dispersion_lines_px);
  switch (options.merge) {
    case Merge::kBalanced:
      return Share(query.n_points, options.line_weight * query.n_lines);
    case Merge::kPaper:
      return 0.5 * (strength + dispersion);
    case Merge::kStrength:
      return strength;
    case Merge::kDispersion:
      return dispersion;
    case Merge::kPoints:
      return 1.0;
    case Merge::kLines:
      return 0.0;
    case Merge::kAdaptive:
      break;
  }
  throw std::logic_error("the weights of an adaptive merge do not add up to one");
}

}  // namespace

PlaceWeights WeightsFor(const PlaceDescription& query, const PlaceOptions& options) {
  if (options.merge == Merge::kAdaptive) {
    const double lines = options.line_weight * query.n_lines;
    const double all = query.n_points + lines + kUnsharedPoints;
    return {query.n_points / all, lines / all};
  }
  const double points = WeightOfPoints(query, options);
  return {points, 1.0 - points};
}

std::vector<float> WordWeights(const std::vector<int>& places_with, int places, const PlaceOptions& options) {
  std::vector<float> word_weights(places_with.size(), 1.0F);
  if (options.merge != Merge::kAdaptive) return word_weights;
  for (size_t i = 0; i < word_weights.size(); ++i) {
    const double without = 1.0 - places_with[i] / (places + kPlacesWithoutWords);
    word_weights[i] = static_cast<float>(std::pow(without, options.idf_exponent));
  }
  return word_weights;
}

namespace {

constexpr int kBlockBits = 16;
constexpr uint32_t kPlaceMask = (1U << kBlockBits) - 1;

// A weight is coded by the upper bits of its float representation, above the smallest coded weight: 2^-31 to 1.
constexpr int kDroppedBits = 12;
constexpr uint32_t kCodeOne = 0xFFFF;
constexpr uint32_t kSmallest = std::bit_cast<uint32_t>(1.0F) - (kCodeOne << kDroppedBits);

uint32_t CodeOf(float weight) {
  const uint32_t bits = std::bit_cast<uint32_t>(std::clamp(weight, std::bit_cast<float>(kSmallest), 1.0F));
  return (bits - kSmallest + (1U << (kDroppedBits - 1))) >> kDroppedBits;
}

/// Prefetches the entries of a word: most of a query's time is waiting for memory.
void Prefetch(const std::vector<uint32_t>& entries) {
  constexpr size_t kEntriesInCacheLine = 16;
  for (size_t i = 0; i < entries.size(); i += kEntriesInCacheLine) __builtin_prefetch(entries.data() + i);
}

float WeightOf(uint32_t entry) { return std::bit_cast<float>(kSmallest + ((entry >> kBlockBits) << kDroppedBits)); }

}  // namespace

void PlaceIndex::Add(int place, const BagOfWords& bag) {
  const size_t block = static_cast<size_t>(place) >> kBlockBits;
  while (blocks_.size() <= block) blocks_.emplace_back(words_);
  for (const auto& [word, weight] : bag.words) {
    if (word < words_) blocks_[block][word].push_back(CodeOf(weight) << kBlockBits | (place & kPlaceMask));
  }
}

void PlaceIndex::Remove(int place, const BagOfWords& bag) {
  const size_t block = static_cast<size_t>(place) >> kBlockBits;
  if (block >= blocks_.size()) return;
  const uint32_t wanted = static_cast<uint32_t>(place) & kPlaceMask;
  for (const auto& [word, weight] : bag.words) {
    if (word >= words_) continue;
    std::vector<uint32_t>& entries = blocks_[block][word];
    const auto entry =
        std::find_if(entries.begin(), entries.end(), [wanted](uint32_t e) { return (e & kPlaceMask) == wanted; });
    if (entry == entries.end()) continue;
    *entry = entries.back();
    entries.pop_back();
  }
}

void PlaceIndex::Score(const BagOfWords& query, std::vector<float>& scores) const {
  Score(query, std::vector<float>(query.words.size(), 1.0F), scores);
}

void PlaceIndex::Score(const BagOfWords& query, const std::vector<float>& word_weights,
                       std::vector<float>& scores) const {
  const auto first = query.words.begin();
  const auto last = std::find_if(first, query.words.end(), [this](const auto& word) { return word.first >= words_; });
  for (size_t b = 0; b < blocks_.size(); ++b) {
    const Block& block = blocks_[b];
    float* const out = scores.data() + (b << kBlockBits);
    for (auto word = first; word != last; ++word) {
      if (last - word > 2) __builtin_prefetch(&block[(word + 2)->first]);
      if (last - word > 1) Prefetch(block[(word + 1)->first]);
      const float counts = word_weights[static_cast<size_t>(word - first)];
      for (const uint32_t entry : block[word->first]) {
        out[entry & kPlaceMask] += counts * std::min(word->second, WeightOf(entry));
      }
    }
  }
}

std::vector<int> PlaceIndex::PlacesWith(const BagOfWords& query) const {
  std::vector<int> counts(query.words.size(), 0);
  for (const Block& block : blocks_) {
    for (size_t i = 0; i < counts.size(); ++i) {
      const int32_t word = query.words[i].first;
      if (word < words_) counts[i] += static_cast<int>(block[word].size());
    }
  }
  return counts;
}

}  // namespace plslam
