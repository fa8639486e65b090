#include "loop_process/map_way.h"

#include <algorithm>
#include <functional>
#include <queue>
#include <utility>

#include "loop_process/map_edges.h"

namespace plslam {
namespace {

constexpr double kTurn_m = 1.0;
// What a step is known to that was never measured by itself: its landmarks have been adjusted.
constexpr double kAdjusted_m = 0.002;
constexpr double kAdjustedPer_m = 0.005;
constexpr double kAdjusted_rad = 0.0005;
constexpr double kAdjusted_radPer_m = 0.0005;

double Length(const SE3& T) { return T.translation().norm() + kTurn_m * T.Log().tail<3>().norm(); }

}  // namespace

MapWays::MapWays(const Map& map, int64_t to) : map_(map) {
  nodes_.reserve(map.keyframes().size());
  for (const auto& [id, keyframe] : map.keyframes()) {
    nodes_.emplace_back();
    nodes_.back().keyframe = &keyframe;
  }
  for (const auto& [id, keyframe] : map.keyframes()) {
    Connect(keyframe.previous_id, id, -1);
    if (keyframe.parent_id != keyframe.previous_id) Connect(keyframe.parent_id, id, -1);
  }
  for (int i = 0; i < static_cast<int>(map.loops().size()); ++i) {
    const LoopEdge& loop = map.loops()[static_cast<size_t>(i)];
    Connect(loop.old_keyframe_id, loop.keyframe_id, i);
  }
  const int place = PlaceOf(to);
  if (place >= 0) Reach(place);
}

int MapWays::PlaceOf(int64_t id) const {
  const auto found = std::lower_bound(nodes_.begin(), nodes_.end(), id,
                                      [](const Node& node, int64_t value) { return node.keyframe->id < value; });
  return found != nodes_.end() && found->keyframe->id == id ? static_cast<int>(found - nodes_.begin()) : -1;
}

void MapWays::Connect(int64_t a, int64_t b, int loop) {
  const int at_a = PlaceOf(a);
  const int at_b = PlaceOf(b);
  if (at_a < 0 || at_b < 0 || at_a == at_b) return;
  Node& node_a = nodes_[static_cast<size_t>(at_a)];
  Node& node_b = nodes_[static_cast<size_t>(at_b)];
  const double length_m = Length(node_a.keyframe->T_w_kf.Inverse() * node_b.keyframe->T_w_kf);
  node_a.steps.push_back({at_b, loop, length_m});
  node_b.steps.push_back({at_a, loop, length_m});
}

void MapWays::Reach(int to) {
  using Entry = std::pair<double, int>;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> open;
  nodes_[static_cast<size_t>(to)].distance_m = 0.0;
  open.emplace(0.0, to);
  while (!open.empty()) {
    const auto [distance_m, at] = open.top();
    open.pop();
    const Node& node = nodes_[static_cast<size_t>(at)];
    if (distance_m > node.distance_m) continue;
    for (const Step& step : node.steps) {
      Node& next = nodes_[static_cast<size_t>(step.next)];
      const double total_m = distance_m + step.length_m;
      if (next.distance_m >= 0.0 && next.distance_m <= total_m) continue;
      next.distance_m = total_m;
      next.towards = {at, step.loop, step.length_m};
      open.emplace(total_m, step.next);
    }
  }
}

Matrix6d MapWays::StepCovariance(const Node& from, const Step& step) const {
  const MapKeyframe& a = *from.keyframe;
  const MapKeyframe& b = *nodes_[static_cast<size_t>(step.next)].keyframe;
  // Known as that of the step back: turned round.
  const auto backwards = [&](const Matrix6d& covariance) {
    return InverseCovariance(b.T_w_kf.Inverse() * a.T_w_kf, covariance);
  };
  if (step.loop >= 0) {
    const LoopEdge& loop = map_.loops()[static_cast<size_t>(step.loop)];
    return loop.old_keyframe_id == a.id ? loop.covariance : backwards(loop.covariance);
  }
  if (b.previous_id == a.id) return b.relative_covariance;
  if (a.previous_id == b.id) return backwards(a.relative_covariance);
  const double sigma_m = kAdjusted_m + kAdjustedPer_m * step.length_m;
  const double sigma_rad = kAdjusted_rad + kAdjusted_radPer_m * step.length_m;
  Matrix6d covariance = Matrix6d::Zero();
  covariance.diagonal().head<3>().setConstant(sigma_m * sigma_m);
  covariance.diagonal().tail<3>().setConstant(sigma_rad * sigma_rad);
  return covariance;
}

std::optional<MapWay> MapWays::From(int64_t keyframe_id) const {
  const int from = PlaceOf(keyframe_id);
  if (from < 0 || nodes_[static_cast<size_t>(from)].distance_m < 0.0) return std::nullopt;
  MapWay way;
  way.length_m = nodes_[static_cast<size_t>(from)].distance_m;
  std::vector<Eigen::Vector3d> places;
  for (const Node* node = &nodes_[static_cast<size_t>(from)]; node->towards.next >= 0;) {
    const Node& next = nodes_[static_cast<size_t>(node->towards.next)];
    const SE3 T_at_next = node->keyframe->T_w_kf.Inverse() * next.keyframe->T_w_kf;
    way.covariance = ComposeCovariance(way.covariance, T_at_next, StepCovariance(*node, node->towards));
    places.push_back(node->keyframe->T_w_kf.translation());
    node = &next;
    if (node->towards.next >= 0) continue;
    for (const Eigen::Vector3d& place : places) {
      way.reach_m = std::max(way.reach_m, (place - node->keyframe->T_w_kf.translation()).norm());
    }
  }
  return way;
}

}  // namespace plslam
