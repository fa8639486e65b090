#pragma once

#include <cstdint>
#include <vector>

#include "core/map/map.h"

namespace plslam {

/// What connects two keyframes of a map, a < b: they follow each other in a session, are parent and child, share many landmarks,
/// or a loop was closed between them; often several of these.
struct MapEdge {
  int64_t a = -1;
  int64_t b = -1;
  int shared = 0;
  bool odometry = false;
  /// It holds the two together: more than a step that is not known.
  bool tied = false;
  /// The newest loop between the two, place in `Map::loops()`; -1: none.
  int loop = -1;
};

/// Whether odometry knows how a keyframe lies to the one before it. Where the tracker was lost in between it does not: it says
/// ten metres and a radian, or how far it may have gone meanwhile. Then a gate that asks how far the map may have drifted says
/// nothing.
bool IsKnownStep(const MapKeyframe& keyframe);

/// Whether the two lie to each other as the map says: not where the parent is only the keyframe before, for want of another,
/// and the step from there is not known.
bool IsTiedToParent(const MapKeyframe& keyframe, const Map& map);

/// Odometry, spanning tree, essential graph (Map::kEssential) and loops: what loops are closed in (PL-SLAM §VI.B).
/// Ascending by a, then b, each pair once.
std::vector<MapEdge> MapEdges(const Map& map);

}  // namespace plslam
