// SPDX-License-Identifier: BSD-3-Clause
#include "mapping_process/insertion/loop_edges.h"

#include <algorithm>
#include <cstdlib>
#include <iterator>
#include <optional>
#include <utility>

#include "core/map/map_graph.h"

namespace plslam::mapping {
namespace {

/// A keyframe of the map that replaces a culled one, and their relative pose.
struct Substitute {
  KeyframeId keyframe_id = -1;
  SE3 T_substitute_culled;
};

/// Returns the keyframe of the session with the nearest number; keyframes near in space may belong to the other end.
const MapKeyframe* NextInSession(const KeyframeName& culled, const Map& map) {
  const MapKeyframe* next = nullptr;
  const auto steps = [&](const MapKeyframe& keyframe) { return std::abs(keyframe.name.number - culled.number); };
  for (const auto& [id, keyframe] : map.keyframes()) {
    if (keyframe.name.session == culled.session && (next == nullptr || steps(keyframe) < steps(*next)))
      next = &keyframe;
  }
  return next;
}

std::optional<Substitute> SubstituteOf(KeyframeId culled_id, const LoopClosure& closure, const Map& map) {
  const auto is_it = [culled_id](const auto& of) { return of.keyframe_id == culled_id; };
  const auto pose = std::find_if(closure.poses.begin(), closure.poses.end(), is_it);
  const auto named = std::find_if(closure.names.begin(), closure.names.end(), is_it);
  if (pose == closure.poses.end() || named == closure.names.end()) return std::nullopt;
  const MapKeyframe* next = NextInSession(named->name, map);
  if (next == nullptr) return std::nullopt;
  return Substitute{next->id, next->T_w_kf.Inverse() * pose->T_w_kf};
}

/// Replaces a culled old end by another keyframe. (The covariance is expressed at the other end and does not change.)
std::optional<LoopEdge> FromKeyframeOfMap(LoopEdge edge, const LoopClosure& closure, const Map& map) {
  if (map.FindKeyframe(edge.old_keyframe_id) != nullptr) return edge;
  const auto substitute = SubstituteOf(edge.old_keyframe_id, closure, map);
  if (!substitute) return std::nullopt;
  edge.old_keyframe_id = substitute->keyframe_id;
  edge.T_old_kf = substitute->T_substitute_culled * edge.T_old_kf;
  return edge;
}

LoopEdge OlderFirst(const LoopEdge& edge) { return edge.old_keyframe_id < edge.keyframe_id ? edge : Reversed(edge); }

/// Returns the edge with its newer end at this keyframe.
LoopEdge EndingAt(KeyframeId id, const LoopEdge& edge) { return edge.keyframe_id == id ? edge : Reversed(edge); }

/// The keyframe that takes the place of a removed one in its loops.
struct Heir {
  KeyframeId keyframe_id = -1;
  Matrix6d covariance = Matrix6d::Zero();  ///< of the removed keyframe's pose relative to it
};

std::optional<Heir> HeirInSession(const MapKeyframe& removed, const Map& map) {
  const bool has_previous = map.FindKeyframe(removed.previous_id) != nullptr;
  const Heir previous{removed.previous_id, removed.relative_covariance};
  const MapKeyframe* const next = NextInSession(removed.id, map);
  if (next == nullptr) return has_previous ? std::optional(previous) : std::nullopt;
  if (has_previous && previous.covariance.trace() <= next->relative_covariance.trace()) return previous;
  return Heir{next->id, InverseCovariance(next->T_prevkf_kf, next->relative_covariance)};
}

Heir HeirElsewhere(const MapKeyframe& removed, const LoopEdge& first, const Map& map) {
  if (map.FindKeyframe(removed.parent_id) != nullptr) return {.keyframe_id = removed.parent_id};
  const LoopEdge edge = EndingAt(removed.id, first);
  return {edge.old_keyframe_id, edge.covariance};
}

}  // namespace

PassedOnLoops LoopsPassedOn(KeyframeId removed_id, const Map& map) {
  PassedOnLoops passed_on;
  std::vector<LoopEdge> loops;
  std::ranges::copy_if(map.loops(), std::back_inserter(loops),
                       [removed_id](const LoopEdge& loop) { return loop.EndsAt(removed_id); });
  if (loops.empty()) return passed_on;
  const MapKeyframe& removed = *map.FindKeyframe(removed_id);
  const std::optional<Heir> in_session = HeirInSession(removed, map);
  passed_on.ends_session = !in_session;
  const Heir heir = in_session ? *in_session : HeirElsewhere(removed, loops.front(), map);
  const SE3 T_removed_heir = removed.T_w_kf.Inverse() * map.FindKeyframe(heir.keyframe_id)->T_w_kf;
  const Matrix6d covariance = InverseCovariance(T_removed_heir.Inverse(), heir.covariance);
  for (const LoopEdge& loop : loops) {
    LoopEdge edge = EndingAt(removed_id, loop);
    if (edge.old_keyframe_id == heir.keyframe_id) continue;
    edge.keyframe_id = heir.keyframe_id;
    edge.covariance = ComposeCovariance(edge.covariance, T_removed_heir, covariance);
    edge.T_old_kf = edge.T_old_kf * T_removed_heir;
    passed_on.edges.push_back(OlderFirst(edge));
  }
  return passed_on;
}

void AddNeeded(const PassedOnLoops& loops, Map& map) {
  for (const LoopEdge& edge : loops.edges) {
    const bool has_loop = std::ranges::any_of(map.loops(), [&edge](const LoopEdge& other) {
      return other.EndsAt(edge.old_keyframe_id) && other.EndsAt(edge.keyframe_id);
    });
    if (has_loop || map.Shared(edge.old_keyframe_id, edge.keyframe_id) >= Map::kEssential) continue;
    if (loops.ends_session &&
        MapGraph(map).Component(edge.old_keyframe_id, MapGraph::Edges::kKnown).contains(edge.keyframe_id))
      continue;
    map.Add(edge);
  }
}

LoopEdge Reversed(const LoopEdge& edge) {
  LoopEdge reversed = edge;
  std::swap(reversed.old_keyframe_id, reversed.keyframe_id);
  reversed.T_old_kf = edge.T_old_kf.Inverse();
  reversed.covariance = InverseCovariance(edge.T_old_kf, edge.covariance);
  return reversed;
}

std::vector<LoopEdge> EdgesInMap(const LoopClosure& closure, const Map& map) {
  std::vector<LoopEdge> edges;
  for (const LoopEdge& edge_in_closure : closure.edges) {
    std::optional<LoopEdge> edge = FromKeyframeOfMap(edge_in_closure, closure, map);
    if (edge && map.FindKeyframe(edge->keyframe_id) == nullptr) {
      edge = FromKeyframeOfMap(Reversed(*edge), closure, map);
    }
    if (!edge || edge->keyframe_id == edge->old_keyframe_id) continue;
    edges.push_back(OlderFirst(*edge));
  }
  return edges;
}

}  // namespace plslam::mapping
