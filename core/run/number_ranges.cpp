// SPDX-License-Identifier: BSD-3-Clause
#include "core/run/number_ranges.h"

#include <fmt/format.h>

#include <charconv>
#include <sstream>

namespace plslam {
namespace {

constexpr size_t kMostNumbers = 1'000'000;

bool ReadNumber(const char*& begin, const char* end, int64_t& number) {
  const auto [rest, error] = std::from_chars(begin, end, number);
  if (error != std::errc() || number < 0) return false;
  begin = rest;
  return true;
}

}  // namespace

std::string NumberRanges(const std::vector<int64_t>& numbers, size_t max_bytes) {
  std::string text;
  for (size_t i = 0; i < numbers.size();) {
    size_t last = i;
    while (last + 1 < numbers.size() && numbers[last + 1] == numbers[last] + 1) ++last;
    const std::string range =
        last == i ? fmt::format("{}", numbers[i]) : fmt::format("{}-{}", numbers[i], numbers[last]);
    if (text.size() + 1 + range.size() > max_bytes) break;
    text += (text.empty() ? "" : " ") + range;
    i = last + 1;
  }
  return text;
}

std::set<int64_t> NumbersInRanges(const std::string& text) {
  std::set<int64_t> numbers;
  std::istringstream words(text);
  for (std::string word; words >> word;) {
    const char* at = word.data();
    const char* const end = at + word.size();
    int64_t first = 0;
    if (!ReadNumber(at, end, first)) continue;
    int64_t last = first;
    if (at != end && (*at++ != '-' || !ReadNumber(at, end, last) || at != end)) continue;
    for (int64_t n = first; n <= last && numbers.size() < kMostNumbers; ++n) numbers.insert(n);
  }
  return numbers;
}

}  // namespace plslam
