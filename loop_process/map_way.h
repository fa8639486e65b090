#pragma once

#include <cstdint>
#include <optional>

#include "core/geometry/se3.h"
#include "core/map/map.h"

namespace plslam {

/// The shortest way through a map from one keyframe to another, along what connects them: odometry, spanning tree, essential
/// graph and loops.
struct MapWay {
  /// Turns count as much as metres: they make errors too.
  double length_m = 0.0;
  /// Farthest that a keyframe of the way lies from its end: the lever of an error of rotation.
  double reach_m = 0.0;
  /// Of T_from_to, right perturbation, from the motions between keyframes as first measured.
  Matrix6d covariance = Matrix6d::Zero();
};

/// nullopt where nothing connects them: the map does not know how they lie to each other.
std::optional<MapWay> ShortestWay(const Map& map, int64_t from, int64_t to);

}  // namespace plslam
