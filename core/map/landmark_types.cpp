// SPDX-License-Identifier: BSD-3-Clause
#include "core/map/landmark_types.h"

#include <algorithm>

namespace plslam {

std::vector<KeyframeId> MostCounted(const std::map<KeyframeId, int>& counts, int max_count) {
  std::vector<KeyframeId> ids;
  ids.reserve(counts.size());
  for (const auto& [id, count] : counts) ids.push_back(id);
  std::stable_sort(ids.begin(), ids.end(),
                   [&counts](KeyframeId a, KeyframeId b) { return counts.at(a) > counts.at(b); });
  if (static_cast<int>(ids.size()) > max_count) ids.resize(static_cast<size_t>(std::max(0, max_count)));
  return ids;
}

}  // namespace plslam
