#include "core/map/keyframe_names.h"

#include <set>

namespace plslam {
namespace {

std::vector<KeyframeName> NamesOf(const std::set<int64_t>& ids, const Map& map) {
  std::vector<KeyframeName> names;
  names.reserve(ids.size());
  for (const int64_t id : ids) {
    const MapKeyframe* keyframe = map.FindKeyframe(id);
    if (keyframe != nullptr) names.push_back({id, keyframe->session, keyframe->session_keyframe_id});
  }
  return names;
}

}  // namespace

std::vector<KeyframeName> NamesIn(const Map& map, const std::vector<int64_t>& keyframe_ids) {
  return NamesOf({keyframe_ids.begin(), keyframe_ids.end()}, map);
}

std::vector<KeyframeName> NamesIn(const Map& map, const LoopClosure& closure) {
  std::set<int64_t> ids;
  for (const LoopEdge& edge : closure.edges) ids.insert({edge.old_keyframe_id, edge.keyframe_id});
  for (const CorrectedPose& pose : closure.poses) ids.insert(pose.keyframe_id);
  return NamesOf(ids, map);
}

}  // namespace plslam
