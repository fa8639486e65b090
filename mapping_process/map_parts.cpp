#include "mapping_process/map_parts.h"

#include <map>
#include <vector>

namespace plslam {

std::set<int64_t> PartOf(int64_t keyframe_id, const Map& map) {
  std::map<int64_t, std::vector<int64_t>> ties;
  const auto tie = [&](int64_t a, int64_t b) {
    if (map.FindKeyframe(a) == nullptr || map.FindKeyframe(b) == nullptr) return;
    ties[a].push_back(b);
    ties[b].push_back(a);
  };
  for (const auto& [id, keyframe] : map.keyframes()) {
    tie(id, keyframe.parent_id);
    tie(id, keyframe.previous_id);
  }
  for (const LoopEdge& loop : map.loops()) tie(loop.old_keyframe_id, loop.keyframe_id);
  std::set<int64_t> part{keyframe_id};
  std::vector<int64_t> open{keyframe_id};
  while (!open.empty()) {
    const int64_t id = open.back();
    open.pop_back();
    for (const int64_t other : ties[id]) {
      if (part.insert(other).second) open.push_back(other);
    }
  }
  return part;
}

}  // namespace plslam
