// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <set>
#include <vector>

#include "core/map/map.h"

namespace plslam {

/// Connection of two keyframes of a map, a < b: consecutive in a session, parent and child, many shared landmarks, or a
/// closed loop; often several of these.
struct MapEdge {
  KeyframeId a = -1;
  KeyframeId b = -1;
  /// Landmarks that both observe.
  int shared = 0;
  /// Consecutive in a session.
  bool odometry = false;
  /// Whether the relative pose of the two is known. It is not if the only connection is an odometry step during which
  /// the tracker was lost (`IsKnownStep`).
  bool known = false;
  /// Index into `Map::loops()` of the newest loop between the two; -1: none.
  int loop = -1;
};

/// Whether odometry measured the motion from the previous keyframe. If the tracker was lost in between, it did not:
/// the covariance is then ten metres and a radian, or as large as the possible motion meanwhile.
bool IsKnownStep(const MapKeyframe& keyframe);

/// Returns the next keyframe of a session after this one; nullptr if there is none. Linear in the number of keyframes.
const MapKeyframe* NextInSession(KeyframeId id, const Map& map);

/// Whether the pose of a keyframe relative to its parent is known. It is not if the parent is merely the previous
/// keyframe, for lack of another, and the step from there is unknown.
bool IsKnownParent(const MapKeyframe& keyframe, const Map& map);

/// The graph of a map (PL-SLAM §VI.B): keyframes, and edges by odometry, spanning tree, essential graph
/// (`Map::kEssential`) and loops, used by mapping, loop correction and exports. (`MapPaths` of loop_process measures
/// paths on a sparser graph of the same known steps.) A copy: later changes of the map have no effect.
class MapGraph {
 public:
  /// Edges that connect keyframes: all, or only known ones.
  enum class Edges { kAll, kKnown };

  explicit MapGraph(const Map& map);

  /// Ascending by a, then b, each pair once.
  const std::vector<MapEdge>& edges() const { return edges_; }

  /// Returns the ids of the keyframes connected with `keyframe_id`, including itself. A session that began unconnected
  /// is a component of its own until an edge connects it.
  std::set<KeyframeId> Component(KeyframeId keyframe_id, Edges which) const;

 private:
  std::vector<MapEdge> edges_;
};

}  // namespace plslam
