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
  /// Sum over the steps; a rotation of one radian counts as a metre, because it causes errors, too.
  double length_m = 0.0;
  /// Largest distance of a keyframe of the path from its end: the lever arm of a rotation error.
  double reach_m = 0.0;
};

/// Shortest paths to one keyframe of a map along odometry, the spanning tree and loops (Dijkstra), from which the
/// drift between two keyframes follows. The map must not change, and must outlive this. The search runs on demand and
/// no farther than needed: in a large map it takes milliseconds, and most keyframes need none.
class MapPaths {
 public:
  MapPaths(const Map& map, KeyframeId to) : map_(map), to_id_(to) {}

  /// Returns nullopt if no chain of known steps (`IsKnownStep`) and loops connects the two keyframes: their relative
  /// pose is then unknown.
  std::optional<MapPath> From(KeyframeId keyframe_id);

  /// Returns the covariance of T_from_to, right perturbation, accumulated along the path: steps of odometry as
  /// measured, loops by their covariance, other edges of the spanning tree by constants. Zero without a path.
  /// Results are cached, because paths share most of their steps.
  Matrix6d CovarianceFrom(KeyframeId keyframe_id);

 private:
  /// An undirected edge between nodes a and b (indices). `loop` is the index of the map's loop, -1 if it is none.
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
    bool settled = false;  ///< the shortest path is final
    int towards = -1;      ///< next edge of the path; -1 at the end, or without a path
    int covariance = -1;
  };

  // Entry of the priority queue: distance in metres, index of the node.
  using Open = std::pair<double, int>;

  int IndexOf(KeyframeId id) const;
  int Reached(KeyframeId id);
  void MakeGraph();
  void Connect(KeyframeId a, KeyframeId b, int loop);
  void SortEdgesByNode();
  void SearchUntil(int place);
  void Leave(int place);
  int Next(int place) const;
  Matrix6d StepCovariance(int from) const;

  const Map& map_;
  KeyframeId to_id_;
  int to_ = -1;
  std::vector<Node> nodes_;      // ascending by id
  std::vector<KeyframeId> ids_;  // of the nodes, sorted: ids may have large gaps
  std::vector<Edge> edges_;
  // Ends of edges grouped by node; ends 2 e and 2 e + 1 belong to edge e.
  Buckets<int> ends_of_;
  std::priority_queue<Open, std::vector<Open>, std::greater<>> open_;
  std::vector<Matrix6d> covariances_;
};

}  // namespace plslam::loop
