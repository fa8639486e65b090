// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <queue>
#include <utility>
#include <vector>

#include "core/features/matching/buckets.h"
#include "core/geometry/se3.h"
#include "core/map/map.h"

namespace plslam::loop {

/// A path through a map from one keyframe to another.
struct MapPath {
  /// A turn of a radian counts as a metre: it makes errors too.
  double length_m = 0.0;
  /// Farthest that a keyframe of the path lies from its end: the lever of an error of rotation.
  double reach_m = 0.0;
};

/// Shortest paths to one keyframe of a map along odometry, the spanning tree and loops (Dijkstra): how far the map
/// may be wrong about where two keyframes lie to each other. The map must stay as it is, and outlive this. They are
/// looked for when they are asked for, and no farther: in a large map that takes milliseconds, and most keyframes ask
/// for none.
class MapPaths {
 public:
  MapPaths(const Map& map, int64_t to) : map_(map), to_id_(to) {}

  /// nullopt where nothing that is known (`IsKnownStep`) connects the two: the map does not know how they lie to each
  /// other.
  std::optional<MapPath> From(int64_t keyframe_id);

  /// Of T_from_to, right perturbation, from the motions between keyframes as first measured. Zero where there is no
  /// path. Paths have much in common, and what was asked for before is remembered.
  Matrix6d CovarianceFrom(int64_t keyframe_id);

 private:
  /// From a to b, or back; places among the nodes. `loop`: place among the loops of the map; -1: none.
  struct Edge {
    int a = -1;
    int b = -1;
    int loop = -1;
    double length_m = 0.0;
  };
  struct Node {
    const MapKeyframe* keyframe = nullptr;
    double distance_m = -1.0;
    double reach_m = 0.0;
    bool settled = false;  ///< no shorter path can be found
    int towards = -1;      ///< edge of the path; -1: the end, or no path
    int covariance = -1;
  };

  // Entry of the queue of Dijkstra: distance, place.
  using Open = std::pair<double, int>;

  int PlaceOf(int64_t id) const;
  int Reached(int64_t id);
  void MakeGraph();
  void Connect(int64_t a, int64_t b, int loop);
  void SortEdgesByNode();
  void SearchUntil(int place);
  void Leave(int place);
  int Next(int place) const;
  Matrix6d StepCovariance(int from) const;

  const Map& map_;
  int64_t to_id_;
  int to_ = -1;
  std::vector<Node> nodes_;   // ascending by id
  std::vector<int64_t> ids_;  // of the nodes; a table by id would be as long as the largest
  std::vector<Edge> edges_;
  // Ends of edges by the node they are at; ends 2 e and 2 e + 1 are of edge e.
  Buckets<int> ends_of_;
  std::priority_queue<Open, std::vector<Open>, std::greater<>> open_;
  std::vector<Matrix6d> covariances_;
};

}  // namespace plslam::loop
