// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <set>
#include <string>
#include <vector>

namespace plslam {

/// Returns ascending numbers >= 0 as text: "3-57 60". Numbers that do not fit into `max_bytes` are left out.
std::string NumberRanges(const std::vector<int64_t>& numbers, size_t max_bytes = 900);

/// The inverse; words that are not a range are ignored, and so is everything beyond a million numbers.
std::set<int64_t> NumbersInRanges(const std::string& text);

}  // namespace plslam
