// SPDX-License-Identifier: BSD-3-Clause
#include "core/map/map_graph.h"

#include <algorithm>
#include <map>
#include <utility>

namespace plslam {
namespace {

// A step is unknown above these standard deviations, or above this share of its length. With uninterrupted tracking
// they are at most 8 mm, 3 % (of steps of decimetres) and 2 mrad; after a second without tracking, metres and radians.
// The gate of the drift test is at 25 of them.
constexpr double kUnknown_m = 0.2;
constexpr double kUnknownShare = 0.1;
constexpr double kUnknown_rad = 0.05;

class EdgesByPair {
 public:
  explicit EdgesByPair(const Map& map) : map_(map) {}

  // Returns nullptr if one of them is not in the map.
  MapEdge* Between(KeyframeId a, KeyframeId b) {
    if (a == b || map_.FindKeyframe(a) == nullptr || map_.FindKeyframe(b) == nullptr) return nullptr;
    const auto pair = std::minmax(a, b);
    const auto [entry, is_new] = edges_.try_emplace(std::pair<KeyframeId, KeyframeId>(pair));
    if (is_new) entry->second = {pair.first, pair.second, map_.Shared(a, b)};
    return &entry->second;
  }

  std::vector<MapEdge> All() const {
    std::vector<MapEdge> all;
    all.reserve(edges_.size());
    for (const auto& [pair, edge] : edges_) all.push_back(edge);
    return all;
  }

 private:
  const Map& map_;
  std::map<std::pair<KeyframeId, KeyframeId>, MapEdge> edges_;
};

}  // namespace

bool IsKnownStep(const MapKeyframe& keyframe) {
  const double most_m = std::max(kUnknown_m, kUnknownShare * keyframe.T_prevkf_kf.translation().norm());
  const auto variances = keyframe.relative_covariance.diagonal().array();
  return (variances.head<3>() <= most_m * most_m).all() && (variances.tail<3>() <= kUnknown_rad * kUnknown_rad).all();
}

const MapKeyframe* NextInSession(KeyframeId id, const Map& map) {
  for (const auto& [next_id, keyframe] : map.keyframes()) {
    if (keyframe.previous_id == id) return &keyframe;
  }
  return nullptr;
}

bool IsKnownParent(const MapKeyframe& keyframe, const Map& map) {
  return IsKnownStep(keyframe) || map.Shared(keyframe.parent_id, keyframe.id) >= Map::kParent;
}

MapGraph::MapGraph(const Map& map) {
  EdgesByPair edges(map);
  for (const auto& [id, keyframe] : map.keyframes()) {
    if (MapEdge* edge = edges.Between(keyframe.previous_id, id)) {
      edge->odometry = true;
      edge->known = edge->known || IsKnownStep(keyframe);
    }
    if (MapEdge* edge = edges.Between(keyframe.parent_id, id)) {
      edge->known = edge->known || IsKnownParent(keyframe, map);
    }
    for (const Map::Neighbour& neighbour : map.Neighbours(id, Map::kEssential)) {
      if (neighbour.keyframe_id > id) edges.Between(id, neighbour.keyframe_id)->known = true;
    }
  }
  for (int i = 0; i < static_cast<int>(map.loops().size()); ++i) {
    const LoopEdge& loop = map.loops()[static_cast<size_t>(i)];
    if (MapEdge* edge = edges.Between(loop.old_keyframe_id, loop.keyframe_id)) {
      edge->loop = i;
      edge->known = true;
    }
  }
  edges_ = edges.All();
}

std::set<KeyframeId> MapGraph::Component(KeyframeId keyframe_id, Edges which) const {
  std::map<KeyframeId, std::vector<KeyframeId>> neighbours;
  for (const MapEdge& edge : edges_) {
    if (which == Edges::kKnown && !edge.known) continue;
    neighbours[edge.a].push_back(edge.b);
    neighbours[edge.b].push_back(edge.a);
  }
  std::set<KeyframeId> component{keyframe_id};
  std::vector<KeyframeId> open{keyframe_id};
  while (!open.empty()) {
    const KeyframeId at = open.back();
    open.pop_back();
    for (const KeyframeId next : neighbours[at]) {
      if (component.insert(next).second) open.push_back(next);
    }
  }
  return component;
}

}  // namespace plslam
