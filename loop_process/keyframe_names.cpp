#include "loop_process/keyframe_names.h"

#include <cstdint>
#include <set>

namespace plslam {

std::vector<KeyframeName> NamesIn(const Map& map, const LoopClosure& closure) {
  std::set<int64_t> ids;
  for (const LoopEdge& edge : closure.edges) ids.insert({edge.old_keyframe_id, edge.keyframe_id});
  for (const CorrectedPose& pose : closure.poses) ids.insert(pose.keyframe_id);
  std::vector<KeyframeName> names;
  names.reserve(ids.size());
  for (const int64_t id : ids) {
    const MapKeyframe* keyframe = map.FindKeyframe(id);
    if (keyframe != nullptr) names.push_back({id, keyframe->session, keyframe->session_keyframe_id});
  }
  return names;
}

}  // namespace plslam
