// SPDX-License-Identifier: BSD-3-Clause
#include "core/config/nearest_key.h"

#include <algorithm>

namespace plslam {
namespace {

// Costs in numbers of wrong letters. Users omit a part more often than they add one.
constexpr int kMissingPart = 2;
constexpr int kPartTooMany = 5;

using Parts = std::vector<std::string_view>;

Parts PartsOf(std::string_view key) {
  Parts parts;
  for (size_t dot = key.find('.'); dot != std::string_view::npos; dot = key.find('.')) {
    parts.push_back(key.substr(0, dot));
    key.remove_prefix(dot + 1);
  }
  parts.push_back(key);
  return parts;
}

/// Words that share less than half of their letters are unrelated: one is removed and the other added.
int PartDistance(std::string_view a, std::string_view b) {
  const int distance = EditDistance(a, b);
  return 2 * distance <= static_cast<int>(std::max(a.size(), b.size())) ? distance
                                                                        : distance + kMissingPart + kPartTooMany;
}

/// Returns the edit distance in parts from a written key to a known one.
int KeyDistance(const Parts& a, const Parts& b) {
  std::vector<int> previous(b.size() + 1), current(b.size() + 1);
  for (size_t j = 0; j <= b.size(); ++j) current[j] = kMissingPart * static_cast<int>(j);
  for (size_t i = 1; i <= a.size(); ++i) {
    std::swap(previous, current);
    current[0] = kPartTooMany * static_cast<int>(i);
    for (size_t j = 1; j <= b.size(); ++j) {
      current[j] = std::min({previous[j] + kPartTooMany, current[j - 1] + kMissingPart,
                             previous[j - 1] + PartDistance(a[i - 1], b[j - 1])});
    }
  }
  return current.back();
}

/// Returns the first `n` parts of `key`, or all of it if it has fewer.
std::string_view Group(std::string_view key, size_t n) {
  size_t end = 0;
  for (size_t i = 0; i < n && end != std::string_view::npos; ++i) end = key.find('.', i == 0 ? 0 : end + 1);
  return key.substr(0, end);
}

}  // namespace

int EditDistance(std::string_view a, std::string_view b) {
  const size_t columns = b.size() + 1;
  std::vector<int> two_back(columns), previous(columns), current(columns);
  for (size_t j = 0; j < columns; ++j) current[j] = static_cast<int>(j);
  for (size_t i = 1; i <= a.size(); ++i) {
    std::swap(two_back, previous);
    std::swap(previous, current);
    current[0] = static_cast<int>(i);
    for (size_t j = 1; j < columns; ++j) {
      const int replaced = previous[j - 1] + (a[i - 1] == b[j - 1] ? 0 : 1);
      current[j] = std::min({previous[j] + 1, current[j - 1] + 1, replaced});
      const bool swapped = i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1];
      if (swapped) current[j] = std::min(current[j], two_back[j - 2] + 1);
    }
  }
  return current.back();
}

std::string NearestKey(std::string_view key, const std::vector<std::string>& known) {
  const Parts parts = PartsOf(key);
  std::string_view nearest;
  int smallest = 0;
  for (const std::string& candidate : known) {
    for (const std::string_view one : {Group(candidate, parts.size()), std::string_view(candidate)}) {
      const int distance = KeyDistance(parts, PartsOf(one));
      if (!nearest.empty() && distance >= smallest) continue;
      nearest = one;
      smallest = distance;
    }
  }
  return std::string(nearest);
}

}  // namespace plslam
