#include "core/places/place_index.h"

#include <algorithm>
#include <bit>

namespace plslam {
namespace {

constexpr int kBlockBits = 16;
constexpr uint32_t kPlaceMask = (1U << kBlockBits) - 1;

// A weight's code is the upper part of its bits as a float, above the smallest weight with a code: 2^-31 to 1 have codes.
constexpr int kDroppedBits = 12;
constexpr uint32_t kCodeOne = 0xFFFF;
constexpr uint32_t kSmallest = std::bit_cast<uint32_t>(1.0F) - (kCodeOne << kDroppedBits);

uint32_t CodeOf(float weight) {
  const uint32_t bits = std::bit_cast<uint32_t>(std::clamp(weight, std::bit_cast<float>(kSmallest), 1.0F));
  return (bits - kSmallest + (1U << (kDroppedBits - 1))) >> kDroppedBits;
}

/// Asks for the entries of a word ahead of their use: most of a query's time is waiting for memory.
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

void PlaceIndex::Score(const BagOfWords& query, const std::vector<float>& worth, std::vector<float>& scores) const {
  const auto first = query.words.begin();
  const auto last = std::find_if(first, query.words.end(), [this](const auto& word) { return word.first >= words_; });
  for (size_t b = 0; b < blocks_.size(); ++b) {
    const Block& block = blocks_[b];
    float* const out = scores.data() + (b << kBlockBits);
    for (auto word = first; word != last; ++word) {
      if (last - word > 2) __builtin_prefetch(&block[(word + 2)->first]);
      if (last - word > 1) Prefetch(block[(word + 1)->first]);
      const float counts = worth[static_cast<size_t>(word - first)];
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
