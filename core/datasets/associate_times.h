// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

namespace plslam {

/// Pairs of indices (a, b) of two increasing lists of times that are at most `max_ns` apart, each index at most once,
/// the nearest pairs first served (as TUM's associate.py does), in order of a. Of each a the nearest b before and
/// after it are considered.
std::vector<std::pair<size_t, size_t>> AssociateTimes(const std::vector<int64_t>& a_ns,
                                                      const std::vector<int64_t>& b_ns, int64_t max_ns);

}  // namespace plslam
