#include "core/places/place_index.h"

#include <algorithm>

namespace plslam {

void PlaceIndex::Add(int place, const BagOfWords& bag) {
  for (const auto& [word, weight] : bag.words) {
    if (word < static_cast<int32_t>(places_of_word_.size())) places_of_word_[word].push_back({place, weight});
  }
}

void PlaceIndex::Remove(int place, const BagOfWords& bag) {
  for (const auto& [word, weight] : bag.words) {
    if (word >= static_cast<int32_t>(places_of_word_.size())) continue;
    std::vector<Entry>& entries = places_of_word_[word];
    const auto entry = std::find_if(entries.begin(), entries.end(), [&](const Entry& e) { return e.place == place; });
    if (entry == entries.end()) continue;
    *entry = entries.back();
    entries.pop_back();
  }
}

void PlaceIndex::Score(const BagOfWords& query, std::vector<float>& scores) const {
  float* const out = scores.data();
  for (const auto& [word, weight] : query.words) {
    if (word >= static_cast<int32_t>(places_of_word_.size())) continue;
    for (const Entry& entry : places_of_word_[word]) out[entry.place] += std::min(weight, entry.weight);
  }
}

}  // namespace plslam
