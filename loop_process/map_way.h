#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <vector>

#include "core/geometry/se3.h"
#include "core/map/map.h"

namespace plslam {

/// A way through a map from one keyframe to another.
struct MapWay {
  /// A turn of a radian counts as a metre: it makes errors too.
  double length_m = 0.0;
  /// Farthest that a keyframe of the way lies from its end: the lever of an error of rotation.
  double reach_m = 0.0;
  /// Of T_from_to, right perturbation, from the motions between keyframes as first measured.
  Matrix6d covariance = Matrix6d::Zero();
};

/// Shortest ways to one keyframe of a map along odometry, the spanning tree and loops (Dijkstra): how far the map may be wrong
/// about where two keyframes lie to each other. The map must stay as it is.
class MapWays {
 public:
  MapWays(const Map& map, int64_t to);

  /// nullopt where nothing connects the two: the map does not know how they lie to each other.
  std::optional<MapWay> From(int64_t keyframe_id) const;

 private:
  struct Step {
    int next = -1;  ///< place of the neighbour
    int loop = -1;  ///< place among the loops of the map; -1: none
    double length_m = 0.0;
  };
  struct Node {
    const MapKeyframe* keyframe = nullptr;
    std::vector<Step> steps;
    double distance_m = -1.0;
    Step towards;
  };

  int PlaceOf(int64_t id) const;
  void Connect(int64_t a, int64_t b, int loop);
  void Reach(int to);
  Matrix6d StepCovariance(const Node& from, const Step& step) const;

  const Map& map_;
  std::vector<Node> nodes_;  // ascending by id
};

}  // namespace plslam
