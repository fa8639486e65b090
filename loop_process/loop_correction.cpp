#include "loop_process/loop_correction.h"

#include <algorithm>
#include <map>
#include <set>
#include <utility>

#include "core/map/connected.h"
#include "core/optim/pose_graph/pose_graph.h"
#include "loop_process/map_edges.h"

namespace plslam {
namespace {

// Of an edge between keyframes at the same place: as of one that is so long.
constexpr double kLeast_m = 0.05;
// Shared landmarks that the options speak of; and how much more or fewer of them count.
constexpr double kShared = 100.0;
constexpr double kMaxFactor = 4.0;

Matrix6d EdgeCovariance(const Map& map, const MapEdge& edge, const SE3& T_a_b, const CorrectionOptions& options) {
  if (edge.loop >= 0) return map.loops()[static_cast<size_t>(edge.loop)].covariance;
  const double length_m = kLeast_m + T_a_b.translation().norm() + T_a_b.Log().tail<3>().norm();
  const double sigma_m = options.drift_per_m * length_m;
  const double sigma_rad = options.drift_deg_per_m * kRadPerDeg * length_m;
  const double factor = std::clamp(kShared / std::max(1, edge.shared), 1.0 / kMaxFactor, kMaxFactor);
  Matrix6d covariance = Matrix6d::Zero();
  covariance.diagonal().head<3>().setConstant(factor * sigma_m * sigma_m);
  covariance.diagonal().tail<3>().setConstant(factor * sigma_rad * sigma_rad);
  if (!edge.odometry || edge.shared >= Map::kCovisible) return covariance;
  // Only the tracker knows how these two lie to each other.
  const bool forward = map.FindKeyframe(edge.b)->previous_id == edge.a;
  const Matrix6d& measured = map.FindKeyframe(forward ? edge.b : edge.a)->relative_covariance;
  return covariance + (forward ? measured : InverseCovariance(T_a_b.Inverse(), measured));
}

std::set<int64_t> Side(int64_t id, const std::vector<MapEdge>& edges, bool tied_only) {
  std::vector<std::pair<int64_t, int64_t>> ties;
  ties.reserve(edges.size());
  for (const MapEdge& edge : edges) {
    if (edge.tied || !tied_only) ties.emplace_back(edge.a, edge.b);
  }
  return ConnectedWith(id, ties);
}

// All that the loop brings together, directly or over steps that are not known.
std::set<int64_t> Touched(const LoopEdge& loop, const std::vector<MapEdge>& edges) {
  std::set<int64_t> touched = Side(loop.old_keyframe_id, edges, false);
  if (!touched.contains(loop.keyframe_id)) touched.merge(Side(loop.keyframe_id, edges, false));
  return touched;
}

// Where keyframes start that the loop ties to the rest for the first time: moved as a whole, those that began later.
std::map<int64_t, SE3> Joined(const Map& map, const LoopEdge& loop, const std::vector<MapEdge>& edges) {
  std::map<int64_t, SE3> T_w_kf;
  for (const int64_t id : Touched(loop, edges)) T_w_kf[id] = map.FindKeyframe(id)->T_w_kf;
  const std::set<int64_t> old_side = Side(loop.old_keyframe_id, edges, true);
  if (old_side.contains(loop.keyframe_id)) return T_w_kf;
  const std::set<int64_t> new_side = Side(loop.keyframe_id, edges, true);
  const SE3 T_moved_w = T_w_kf.at(loop.old_keyframe_id) * loop.T_old_kf * T_w_kf.at(loop.keyframe_id).Inverse();
  const bool old_first = *old_side.begin() < *new_side.begin();
  for (const int64_t id : old_first ? new_side : old_side) {
    T_w_kf[id] = (old_first ? T_moved_w : T_moved_w.Inverse()) * T_w_kf[id];
  }
  return T_w_kf;
}

// A pose graph, and the keyframes that its poses are of.
struct LoopGraph {
  std::vector<int64_t> keyframe_ids;
  PoseGraphProblem problem;
};

LoopGraph MakeLoopGraph(const Map& map, const LoopEdge& loop, const CorrectionOptions& options) {
  const std::vector<MapEdge> edges = MapEdges(map);
  LoopGraph graph;
  PoseGraphProblem& problem = graph.problem;
  std::map<int64_t, int> places;
  for (const auto& [id, T_w_kf] : Joined(map, loop, edges)) {
    places[id] = static_cast<int>(problem.poses.size());
    graph.keyframe_ids.push_back(id);
    problem.poses.push_back({T_w_kf, problem.poses.empty()});
  }
  const auto add = [&](int64_t a, int64_t b, const SE3& T_a_b, const Matrix6d& covariance, bool robust) {
    const auto information = InformationFromCovariance(covariance);
    if (information) problem.edges.push_back({places.at(a), places.at(b), T_a_b, *information, robust});
  };
  const auto start = [&](int64_t id) { return problem.poses[static_cast<size_t>(places.at(id))].T_w_kf; };
  for (const MapEdge& edge : edges) {
    if (!places.contains(edge.a)) continue;
    // As the map has it: adjusted since it was measured. A step that is not known must not pull back what the loop joins.
    const SE3 T_a_b = edge.tied ? map.FindKeyframe(edge.a)->T_w_kf.Inverse() * map.FindKeyframe(edge.b)->T_w_kf
                                : start(edge.a).Inverse() * start(edge.b);
    add(edge.a, edge.b, T_a_b, EdgeCovariance(map, edge, T_a_b, options), false);
  }
  add(loop.old_keyframe_id, loop.keyframe_id, loop.T_old_kf, loop.covariance, true);
  return graph;
}

}  // namespace

std::optional<std::vector<CorrectedPose>> CloseLoop(const Map& map, const LoopEdge& loop,
                                                    const CorrectionOptions& options) {
  const auto [keyframe_ids, graph] = MakeLoopGraph(map, loop, options);
  if (graph.edges.empty() || !graph.edges.back().robust) return std::nullopt;
  const PoseGraphResult result = OptimisePoseGraph(graph, options.graph);
  if (!result.ok || result.rejected.back()) return std::nullopt;
  std::vector<CorrectedPose> poses;
  for (size_t i = 0; i < keyframe_ids.size(); ++i) poses.push_back({keyframe_ids[i], result.T_w_kf[i]});
  return poses;
}

}  // namespace plslam
