// SPDX-License-Identifier: BSD-3-Clause
#include "core/map/map_parts.h"

#include <algorithm>
#include <map>
#include <tuple>
#include <utility>

#include "core/map/map_graph.h"

namespace plslam {
namespace {

template <class Landmark>
void PutObserved(const IdMap<LandmarkId, Landmark>& landmarks, const std::set<KeyframeId>& keyframes, Map* part) {
  for (const auto& [id, landmark] : landmarks) {
    const bool is_observed = std::ranges::any_of(
        landmark.observations, [&](const Observation& o) { return keyframes.contains(o.keyframe_id()); });
    if (is_observed) part->Put(landmark);
  }
}

/// Sessions that edges connect, each group known by one of them.
class SessionGroups {
 public:
  void Join(SessionId a, SessionId b) { group_[Find(a)] = Find(b); }
  SessionId Find(SessionId session) const {
    for (auto next = group_.find(session); next != group_.end() && next->second != session;
         next = group_.find(session))
      session = next->second;
    return session;
  }

 private:
  std::map<SessionId, SessionId> group_;
};

}  // namespace

std::vector<std::set<KeyframeId>> PartsOf(const Map& map, const std::function<bool(const MapKeyframe&)>& is_of_run) {
  SessionGroups groups;
  const MapGraph graph(map);
  for (const MapEdge& edge : graph.edges()) {
    groups.Join(map.FindKeyframe(edge.a)->name.session, map.FindKeyframe(edge.b)->name.session);
  }
  std::map<SessionId, std::set<KeyframeId>> of_groups;
  for (const auto& [id, keyframe] : map.keyframes()) of_groups[groups.Find(keyframe.name.session)].insert(id);
  std::vector<std::set<KeyframeId>> parts;
  parts.reserve(of_groups.size());
  for (auto& [group, part] : of_groups) parts.push_back(std::move(part));
  const auto rank = [&](const std::set<KeyframeId>& part) {
    const auto of_run = std::ranges::count_if(part, [&](KeyframeId id) { return is_of_run(*map.FindKeyframe(id)); });
    return std::tuple(-of_run, -static_cast<int64_t>(part.size()), *part.begin());
  };
  std::ranges::sort(parts, {}, rank);
  return parts;
}

Map PartOf(const Map& map, const std::set<KeyframeId>& keyframes) {
  Map part;
  if (map.camera()) part.SetCamera(*map.camera());
  for (const KeyframeId id : keyframes) part.Put(*map.FindKeyframe(id));
  PutObserved(map.points(), keyframes, &part);
  PutObserved(map.lines(), keyframes, &part);
  for (const LoopEdge& loop : map.loops()) {
    if (keyframes.contains(loop.keyframe_id) && keyframes.contains(loop.old_keyframe_id)) part.Add(loop);
  }
  return part;
}

}  // namespace plslam
