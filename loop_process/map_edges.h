#pragma once

#include <cstdint>
#include <vector>

#include "core/geometry/se3.h"
#include "core/map/map.h"

namespace plslam {

/// What connects two keyframes of a map, a < b: they follow each other in a session, are parent and child, share many landmarks,
/// or a loop was closed between them; often several of these.
struct MapEdge {
  int64_t a = -1;
  int64_t b = -1;
  int shared = 0;
  bool odometry = false;
  /// The newest loop between the two, place in `Map::loops()`; -1: none.
  int loop = -1;
};

/// Odometry, spanning tree, essential graph (Map::kEssential) and loops: what loops are closed in (PL-SLAM §VI.B).
/// Ascending by a, then b, each pair once.
std::vector<MapEdge> MapEdges(const Map& map);

/// Covariance of the inverse of a motion, both right perturbations.
Matrix6d InverseCovariance(const SE3& T_a_b, const Matrix6d& covariance);

}  // namespace plslam
