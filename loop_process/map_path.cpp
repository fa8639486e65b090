// SPDX-License-Identifier: BSD-3-Clause
#include "loop_process/map_path.h"

#include <algorithm>
#include <utility>

#include "core/map/map_graph.h"

namespace plslam::loop {
namespace {

constexpr double kTurn_m = 1.0;
// Sigmas of a step that was not measured as an odometry motion or a loop, after bundle adjustment of its landmarks.
constexpr double kAdjusted_m = 0.002;
constexpr double kAdjustedPer_m = 0.005;
constexpr double kAdjusted_rad = 0.0005;
constexpr double kAdjusted_radPer_m = 0.0005;

double Length(const MapKeyframe& a, const MapKeyframe& b) {
  return (a.T_w_kf.translation() - b.T_w_kf.translation()).norm() +
         kTurn_m * a.T_w_kf.rotation().angularDistance(b.T_w_kf.rotation());
}

}  // namespace

int MapPaths::IndexOf(KeyframeId id) const {
  // The guess is exact if no id is missing in between; otherwise the index is smaller.
  if (ids_.empty() || id < ids_.front() || id > ids_.back()) return -1;
  const uint64_t guess = static_cast<uint64_t>(id.value) - static_cast<uint64_t>(ids_.front().value);
  const auto last = ids_.begin() + static_cast<std::ptrdiff_t>(std::min<uint64_t>(guess, ids_.size() - 1));
  const auto found = std::lower_bound(ids_.begin(), last, id);
  return *found == id ? static_cast<int>(found - ids_.begin()) : -1;
}

void MapPaths::MakeGraph() {
  nodes_.reserve(map_.keyframes().size());
  ids_.reserve(map_.keyframes().size());
  for (const auto& [id, keyframe] : map_.keyframes()) {
    nodes_.emplace_back();
    nodes_.back().keyframe = &keyframe;
    ids_.push_back(id);
  }
  edges_.reserve(2 * nodes_.size() + map_.loops().size());
  for (const Node& node : nodes_) {
    const MapKeyframe& keyframe = *node.keyframe;
    const bool known = IsKnownStep(keyframe);
    if (known) Connect(keyframe.previous_id, keyframe.id, -1);
    const bool again = known && keyframe.parent_id == keyframe.previous_id;
    if (!again && IsKnownParent(keyframe, map_)) Connect(keyframe.parent_id, keyframe.id, -1);
  }
  for (int i = 0; i < static_cast<int>(map_.loops().size()); ++i) {
    const LoopEdge& loop = map_.loops()[static_cast<size_t>(i)];
    Connect(loop.old_keyframe_id, loop.keyframe_id, i);
  }
  SortEdgesByNode();
  to_ = IndexOf(to_id_);
  if (to_ < 0) return;
  nodes_[to_].distance_m = 0.0;
  open_.emplace(0.0, to_);
}

void MapPaths::Connect(KeyframeId a, KeyframeId b, int loop) {
  const int at_a = IndexOf(a);
  const int at_b = IndexOf(b);
  if (at_a < 0 || at_b < 0 || at_a == at_b) return;
  edges_.push_back({at_a, at_b, loop, Length(*nodes_[at_a].keyframe, *nodes_[at_b].keyframe)});
}

void MapPaths::SortEdgesByNode() {
  ends_of_ = IndicesByBucket(2 * edges_.size(), nodes_.size(), [this](int end) {
    const Edge& edge = edges_[end / 2];
    return end % 2 == 0 ? edge.a : edge.b;
  });
}

void MapPaths::SearchUntil(int place) {
  while (!open_.empty() && !nodes_[place].settled) {
    const int at = open_.top().second;
    open_.pop();
    if (nodes_[at].settled) continue;
    nodes_[at].settled = true;
    Leave(at);
  }
}

void MapPaths::Leave(int place) {
  const Eigen::Vector3d end = nodes_[to_].keyframe->T_w_kf.translation();
  for (const int edge_end : ends_of_[static_cast<size_t>(place)]) {
    const Edge& edge = edges_[edge_end / 2];
    const int other = edge.a == place ? edge.b : edge.a;
    Node& next = nodes_[other];
    const double total_m = nodes_[place].distance_m + edge.length_m;
    if (next.distance_m >= 0.0 && next.distance_m <= total_m) continue;
    next.distance_m = total_m;
    next.reach_m = std::max(nodes_[place].reach_m, (next.keyframe->T_w_kf.translation() - end).norm());
    next.towards = edge_end / 2;
    open_.emplace(total_m, other);
  }
}

int MapPaths::Next(int place) const {
  const Edge& edge = edges_[nodes_[place].towards];
  return edge.a == place ? edge.b : edge.a;
}

Matrix6d MapPaths::StepCovariance(int from) const {
  const Edge& edge = edges_[nodes_[from].towards];
  const MapKeyframe& a = *nodes_[from].keyframe;
  const MapKeyframe& b = *nodes_[Next(from)].keyframe;
  // Covariance of the inverse step.
  const auto backwards = [&](const Matrix6d& covariance) {
    return InverseCovariance(b.T_w_kf.Inverse() * a.T_w_kf, covariance);
  };
  if (edge.loop >= 0) {
    const LoopEdge& loop = map_.loops()[static_cast<size_t>(edge.loop)];
    return loop.old_keyframe_id == a.id ? loop.covariance : backwards(loop.covariance);
  }
  if (b.previous_id == a.id && IsKnownStep(b)) return b.relative_covariance;
  if (a.previous_id == b.id && IsKnownStep(a)) return backwards(a.relative_covariance);
  const double sigma_m = kAdjusted_m + kAdjustedPer_m * edge.length_m;
  const double sigma_rad = kAdjusted_rad + kAdjusted_radPer_m * edge.length_m;
  Matrix6d covariance = Matrix6d::Zero();
  covariance.diagonal().head<3>().setConstant(sigma_m * sigma_m);
  covariance.diagonal().tail<3>().setConstant(sigma_rad * sigma_rad);
  return covariance;
}

int MapPaths::Reached(KeyframeId id) {
  if (nodes_.empty()) MakeGraph();
  const int place = IndexOf(id);
  if (place < 0) return -1;
  SearchUntil(place);
  return nodes_[place].settled ? place : -1;
}

std::optional<MapPath> MapPaths::From(KeyframeId keyframe_id) {
  const int from = Reached(keyframe_id);
  if (from < 0) return std::nullopt;
  return MapPath{nodes_[from].distance_m, nodes_[from].reach_m};
}

Matrix6d MapPaths::CovarianceFrom(KeyframeId keyframe_id) {
  int place = Reached(keyframe_id);
  if (place < 0) return Matrix6d::Zero();
  std::vector<int> path;
  for (; nodes_[place].covariance < 0 && nodes_[place].towards >= 0; place = Next(place)) path.push_back(place);
  // C_from = sum over the steps of the path of Ad C_step Ad^T, each transported to the frame of the end.
  Matrix6d covariance = nodes_[place].covariance < 0 ? Matrix6d::Zero() : covariances_[nodes_[place].covariance];
  const SE3 T_to_w = nodes_[to_].keyframe->T_w_kf.Inverse();
  for (auto step = path.rbegin(); step != path.rend(); ++step) {
    covariance += InverseCovariance(T_to_w * nodes_[Next(*step)].keyframe->T_w_kf, StepCovariance(*step));
    nodes_[*step].covariance = static_cast<int>(covariances_.size());
    covariances_.push_back(covariance);
  }
  return covariance;
}

}  // namespace plslam::loop
