#include "loop_process/map_way.h"

#include <algorithm>
#include <map>
#include <set>
#include <utility>
#include <vector>

#include "loop_process/map_edges.h"

namespace plslam {
namespace {

// A radian is a metre.
constexpr double kTurn_m = 1.0;
// What an edge without a measured motion of its own is known to: shared landmarks have been adjusted.
constexpr double kAdjusted_m = 0.002;
constexpr double kAdjustedPer_m = 0.005;
constexpr double kAdjusted_rad = 0.0005;
constexpr double kAdjusted_radPer_m = 0.0005;

using Graph = std::map<int64_t, std::vector<const MapEdge*>>;

SE3 Between(const Map& map, int64_t a, int64_t b) {
  return map.FindKeyframe(a)->T_w_kf.Inverse() * map.FindKeyframe(b)->T_w_kf;
}

double Length(const SE3& T) {
  const Vector6d x = T.Log();
  return T.translation().norm() + kTurn_m * x.tail<3>().norm();
}

Matrix6d StepCovariance(const Map& map, const MapEdge& edge, int64_t from, int64_t to) {
  const SE3 T_from_to = Between(map, from, to);
  const auto oriented = [&](int64_t first, const Matrix6d& covariance) {
    return first == from ? covariance : InverseCovariance(T_from_to.Inverse(), covariance);
  };
  if (edge.odometry) {
    const bool forward = map.FindKeyframe(edge.b)->previous_id == edge.a;
    const int64_t later = forward ? edge.b : edge.a;
    return oriented(forward ? edge.a : edge.b, map.FindKeyframe(later)->relative_covariance);
  }
  if (edge.loop >= 0) {
    const LoopEdge& loop = map.loops()[static_cast<size_t>(edge.loop)];
    return oriented(loop.old_keyframe_id, loop.covariance);
  }
  const double length_m = Length(T_from_to);
  const double sigma_m = kAdjusted_m + kAdjustedPer_m * length_m;
  const double sigma_rad = kAdjusted_rad + kAdjusted_radPer_m * length_m;
  Matrix6d covariance = Matrix6d::Zero();
  covariance.diagonal().head<3>().setConstant(sigma_m * sigma_m);
  covariance.diagonal().tail<3>().setConstant(sigma_rad * sigma_rad);
  return covariance;
}

// The edge by which each keyframe is reached from `from`, nullptr for that one, as far as `to` (Dijkstra).
std::map<int64_t, const MapEdge*> Reach(const Map& map, const Graph& graph, int64_t from, int64_t to) {
  std::map<int64_t, double> distance{{from, 0.0}};
  std::map<int64_t, const MapEdge*> by{{from, nullptr}};
  std::set<std::pair<double, int64_t>> open{{0.0, from}};
  while (!open.empty() && open.begin()->second != to) {
    const auto [length_m, at] = *open.begin();
    open.erase(open.begin());
    const auto edges = graph.find(at);
    if (edges == graph.end()) continue;
    for (const MapEdge* edge : edges->second) {
      const int64_t next = edge->a == at ? edge->b : edge->a;
      const double total_m = length_m + Length(Between(map, at, next));
      const auto [entry, is_new] = distance.try_emplace(next, total_m);
      if (!is_new && entry->second <= total_m) continue;
      open.erase({entry->second, next});
      entry->second = total_m;
      by[next] = edge;
      open.insert({total_m, next});
    }
  }
  return by;
}

}  // namespace

std::optional<MapWay> ShortestWay(const Map& map, int64_t from, int64_t to) {
  const std::vector<MapEdge> edges = MapEdges(map);
  Graph graph;
  for (const MapEdge& edge : edges) {
    graph[edge.a].push_back(&edge);
    graph[edge.b].push_back(&edge);
  }
  const auto by = Reach(map, graph, from, to);
  if (!by.contains(to)) return std::nullopt;
  // Backwards, then forwards: covariances are composed from the start.
  std::vector<std::pair<int64_t, const MapEdge*>> steps;
  for (int64_t at = to; by.at(at) != nullptr;) {
    const MapEdge* edge = by.at(at);
    steps.emplace_back(at, edge);
    at = edge->a == at ? edge->b : edge->a;
  }
  MapWay way;
  const Eigen::Vector3d end = map.FindKeyframe(to)->T_w_kf.translation();
  int64_t at = from;
  for (auto step = steps.rbegin(); step != steps.rend(); ++step) {
    const SE3 T_at_next = Between(map, at, step->first);
    way.reach_m = std::max(way.reach_m, (map.FindKeyframe(at)->T_w_kf.translation() - end).norm());
    way.length_m += Length(T_at_next);
    way.covariance =
        ComposeCovariance(way.covariance, T_at_next, StepCovariance(map, *step->second, at, step->first));
    at = step->first;
  }
  return way;
}

}  // namespace plslam
