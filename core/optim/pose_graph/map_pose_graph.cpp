// SPDX-License-Identifier: BSD-3-Clause
#include "core/optim/pose_graph/map_pose_graph.h"

#include <algorithm>

namespace plslam {
namespace {

// Added to the length of each edge, so that edges between coincident keyframes are not certain.
constexpr double kLeast_m = 0.05;
// Number of shared landmarks to which `MapDrift` refers, and the limit of the factor for more or fewer of them.
constexpr double kShared = 100.0;
constexpr double kMaxFactor = 4.0;

Matrix6d EdgeCovariance(const Map& map, const MapEdge& edge, const SE3& T_a_b, const MapDrift& drift) {
  if (edge.loop >= 0) return map.loops()[static_cast<size_t>(edge.loop)].covariance;
  const double length_m = kLeast_m + T_a_b.translation().norm() + T_a_b.Log().tail<3>().norm();
  const double sigma_m = drift.per_m * length_m;
  const double sigma_rad = drift.deg_per_m * kRadPerDeg * length_m;
  const double factor = std::clamp(kShared / std::max(1, edge.shared), 1.0 / kMaxFactor, kMaxFactor);
  Matrix6d covariance = Matrix6d::Zero();
  covariance.diagonal().head<3>().setConstant(factor * sigma_m * sigma_m);
  covariance.diagonal().tail<3>().setConstant(factor * sigma_rad * sigma_rad);
  if (!edge.odometry || edge.shared >= Map::kCovisible) return covariance;
  // The two share few landmarks: only the tracker determines their relative pose.
  const bool forward = map.FindKeyframe(edge.b)->previous_id == edge.a;
  const Matrix6d& measured = map.FindKeyframe(forward ? edge.b : edge.a)->relative_covariance;
  return covariance + (forward ? measured : InverseCovariance(T_a_b.Inverse(), measured));
}

}  // namespace

int MapPoseGraph::IndexOf(KeyframeId keyframe_id) const {
  return static_cast<int>(std::lower_bound(keyframe_ids.begin(), keyframe_ids.end(), keyframe_id) -
                          keyframe_ids.begin());
}

MapPoseGraph PoseGraphOf(const Map& map, const MapGraph& graph, const std::map<KeyframeId, SE3>& T_w_kf,
                         const MapDrift& drift) {
  MapPoseGraph result;
  PoseGraphProblem& problem = result.problem;
  for (const auto& [id, pose] : T_w_kf) {
    result.keyframe_ids.push_back(id);
    problem.poses.push_back({pose, problem.poses.empty()});
  }
  for (const MapEdge& edge : graph.edges()) {
    if (!T_w_kf.contains(edge.a) || !T_w_kf.contains(edge.b)) continue;
    // Measured on the map, which was adjusted since the motion was first measured. An unknown step must not pull back
    // keyframes that a loop joins.
    const SE3 T_a_b = edge.known ? map.FindKeyframe(edge.a)->T_w_kf.Inverse() * map.FindKeyframe(edge.b)->T_w_kf
                                 : T_w_kf.at(edge.a).Inverse() * T_w_kf.at(edge.b);
    const auto information = InformationFromCovariance(EdgeCovariance(map, edge, T_a_b, drift));
    if (information) {
      problem.edges.push_back({result.IndexOf(edge.a), result.IndexOf(edge.b), T_a_b, *information, false});
    }
  }
  return result;
}

MapPoseGraph PoseGraphOf(const Map& map, const MapDrift& drift) {
  std::map<KeyframeId, SE3> T_w_kf;
  for (const auto& [id, keyframe] : map.keyframes()) T_w_kf[id] = keyframe.T_w_kf;
  return PoseGraphOf(map, MapGraph(map), T_w_kf, drift);
}

std::map<KeyframeId, Matrix6d> CovariancesAround(KeyframeId keyframe_id, const Map& map, const MapDrift& drift) {
  const MapGraph graph(map);
  std::map<KeyframeId, SE3> T_w_kf;
  PoseGraphResult as_it_is;
  for (const KeyframeId id : graph.Component(keyframe_id, MapGraph::Edges::kAll)) {
    T_w_kf[id] = map.FindKeyframe(id)->T_w_kf;
    as_it_is.T_w_kf.push_back(T_w_kf[id]);
  }
  const MapPoseGraph poses = PoseGraphOf(map, graph, T_w_kf, drift);
  as_it_is.ok = true;
  as_it_is.rejected.assign(poses.problem.edges.size(), false);
  const std::vector<Matrix6d> marginals = PoseGraphCovariances(poses.problem, as_it_is);
  const MapKeyframe& first = *map.FindKeyframe(poses.keyframe_ids.front());
  std::map<KeyframeId, Matrix6d> covariances;
  for (size_t i = 1; i < marginals.size(); ++i) {
    const KeyframeId id = poses.keyframe_ids[i];
    if (marginals[i].isZero(0.0) || !marginals[i].allFinite()) return {};
    covariances[id] = ComposeCovariance(first.covariance, first.T_w_kf.Inverse() * T_w_kf[id], marginals[i]);
  }
  return covariances;
}

}  // namespace plslam
