#pragma once

#include <cstdint>
#include <map>
#include <set>
#include <utility>
#include <vector>

namespace plslam {

/// Everything that ties lead to from `id`, itself among it.
inline std::set<int64_t> ConnectedWith(int64_t id, const std::vector<std::pair<int64_t, int64_t>>& ties) {
  std::map<int64_t, std::vector<int64_t>> neighbours;
  for (const auto& [a, b] : ties) {
    neighbours[a].push_back(b);
    neighbours[b].push_back(a);
  }
  std::set<int64_t> connected{id};
  std::vector<int64_t> open{id};
  while (!open.empty()) {
    const int64_t at = open.back();
    open.pop_back();
    for (const int64_t next : neighbours[at]) {
      if (connected.insert(next).second) open.push_back(next);
    }
  }
  return connected;
}

}  // namespace plslam
