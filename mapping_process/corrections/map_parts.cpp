#include "mapping_process/corrections/map_parts.h"

#include <utility>
#include <vector>

#include "core/map/connected.h"

namespace plslam {

std::set<int64_t> PartOf(int64_t keyframe_id, const Map& map) {
  std::vector<std::pair<int64_t, int64_t>> ties;
  const auto tie = [&](int64_t a, int64_t b) {
    if (map.FindKeyframe(a) != nullptr && map.FindKeyframe(b) != nullptr) ties.emplace_back(a, b);
  };
  for (const auto& [id, keyframe] : map.keyframes()) {
    tie(id, keyframe.parent_id);
    tie(id, keyframe.previous_id);
  }
  for (const LoopEdge& loop : map.loops()) tie(loop.old_keyframe_id, loop.keyframe_id);
  return ConnectedWith(keyframe_id, ties);
}

}  // namespace plslam
