// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

namespace plslam {

/// Values by id, several of one id in the order in which they came: filled first, then only asked, which costs one
/// block of memory where std::map takes one for each value.
template <class Value>
class IdIndex {
 public:
  using Entry = std::pair<int64_t, Value>;

  explicit IdIndex(std::vector<Entry> entries) : entries_(std::move(entries)) {
    std::stable_sort(entries_.begin(), entries_.end(),
                     [](const Entry& a, const Entry& b) { return a.first < b.first; });
  }

  /// Empty where there is none.
  std::span<const Entry> Find(int64_t id) const {
    const auto [first, last] = std::equal_range(entries_.begin(), entries_.end(), Entry(id, Value()),
                                                [](const Entry& a, const Entry& b) { return a.first < b.first; });
    return {first, last};
  }

 private:
  std::vector<Entry> entries_;
};

/// Where in `list` each id stands; those below zero name nothing.
template <class Element>
IdIndex<size_t> PlacesBy(int64_t Element::*id, const std::vector<Element>& list) {
  std::vector<std::pair<int64_t, size_t>> places;
  places.reserve(list.size());
  for (size_t i = 0; i < list.size(); ++i) {
    if (list[i].*id >= 0) places.emplace_back(list[i].*id, i);
  }
  return IdIndex(std::move(places));
}

}  // namespace plslam
