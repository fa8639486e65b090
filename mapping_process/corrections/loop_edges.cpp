// SPDX-License-Identifier: BSD-3-Clause
#include "mapping_process/corrections/loop_edges.h"

#include <algorithm>
#include <cstdlib>
#include <optional>
#include <utility>

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

}  // namespace

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
    edges.push_back(edge->old_keyframe_id < edge->keyframe_id ? *edge : Reversed(*edge));
  }
  return edges;
}

}  // namespace plslam::mapping
