// SPDX-License-Identifier: BSD-3-Clause
#include "core/datasets/associate_times.h"

#include <algorithm>
#include <tuple>

namespace plslam {
namespace {

// Distance in time, then indices: a total order, so that ties are decided the same way everywhere.
using Candidate = std::tuple<int64_t, size_t, size_t>;

std::vector<Candidate> Candidates(const std::vector<int64_t>& a_ns, const std::vector<int64_t>& b_ns,
                                  int64_t max_ns) {
  std::vector<Candidate> candidates;
  for (size_t a = 0; a < a_ns.size(); ++a) {
    const auto after = std::lower_bound(b_ns.begin(), b_ns.end(), a_ns[a]);
    const auto b = static_cast<size_t>(after - b_ns.begin());
    if (after != b_ns.end() && *after - a_ns[a] <= max_ns) candidates.emplace_back(*after - a_ns[a], a, b);
    if (b > 0 && a_ns[a] - b_ns[b - 1] <= max_ns) candidates.emplace_back(a_ns[a] - b_ns[b - 1], a, b - 1);
  }
  std::sort(candidates.begin(), candidates.end());
  return candidates;
}

}  // namespace

std::vector<std::pair<size_t, size_t>> AssociateTimes(const std::vector<int64_t>& a_ns,
                                                      const std::vector<int64_t>& b_ns, int64_t max_ns) {
  std::vector<bool> a_used(a_ns.size());
  std::vector<bool> b_used(b_ns.size());
  std::vector<std::pair<size_t, size_t>> pairs;
  for (const auto& [distance_ns, a, b] : Candidates(a_ns, b_ns, max_ns)) {
    if (a_used[a] || b_used[b]) continue;
    a_used[a] = b_used[b] = true;
    pairs.emplace_back(a, b);
  }
  std::sort(pairs.begin(), pairs.end());
  return pairs;
}

}  // namespace plslam
