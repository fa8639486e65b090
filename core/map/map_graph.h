// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <set>
#include <vector>

#include "core/map/map.h"

namespace plslam {

/// What connects two keyframes of a map, a < b: they follow each other in a session, are parent and child, share many
/// landmarks, or a loop was closed between them; often several of these.
struct MapEdge {
  int64_t a = -1;
  int64_t b = -1;
  /// Landmarks that both observe.
  int shared = 0;
  /// One follows the other in a session.
  bool odometry = false;
  /// Whether the map knows how the two lie to each other. It does not where the only connection is a step of odometry
  /// during which the tracker was lost (`IsKnownStep`).
  bool known = false;
  /// The newest loop between the two, index into `Map::loops()`; -1: none.
  int loop = -1;
};

/// Whether odometry knows how a keyframe lies to the one before it. Where the tracker was lost in between it does
/// not: its covariance says ten metres and a radian, or how far the camera may have gone meanwhile.
bool IsKnownStep(const MapKeyframe& keyframe);

/// Whether a keyframe and its parent lie to each other as the map says. They do not where the parent is only the
/// keyframe before, for want of another, and the step from there is not known.
bool IsKnownParent(const MapKeyframe& keyframe, const Map& map);

/// The graph of a map (PL-SLAM §VI.B): keyframes, and edges by odometry, spanning tree, essential graph
/// (`Map::kEssential`) and loops. Mapping, loop correction and exports go by this one. (`MapPaths` of loop_process
/// measures paths, along a leaner graph of the same known steps.) It is a copy: later changes of the map are not in
/// it.
class MapGraph {
 public:
  /// Which edges lead from one keyframe to the next: all, or only known ones.
  enum class Edges { kAll, kKnown };

  explicit MapGraph(const Map& map);

  /// Ascending by a, then b, each pair once.
  const std::vector<MapEdge>& edges() const { return edges_; }

  /// Ids of the keyframes that edges lead to from `keyframe_id`, itself among them. A session that began without a
  /// connection is a component of its own until something connects it.
  std::set<int64_t> Component(int64_t keyframe_id, Edges which) const;

 private:
  std::vector<MapEdge> edges_;
};

}  // namespace plslam
