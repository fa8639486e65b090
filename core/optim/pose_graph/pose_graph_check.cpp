// SPDX-License-Identifier: BSD-3-Clause
#include "core/optim/pose_graph/pose_graph_check.h"

#include <fmt/format.h>

#include <algorithm>

#include <Eigen/Cholesky>

#include "core/geometry/symmetric.h"
#include "core/optim/pose_graph/pose_graph_blocks.h"

namespace plslam {
namespace {

template <class Pose>
std::string EdgeObjection(const PoseGraphMotion<Pose>& edge, int n_poses) {
  if (std::min(edge.a, edge.b) < 0 || std::max(edge.a, edge.b) >= n_poses) {
    return fmt::format("joins a pose that is not one of the {}", n_poses);
  }
  if (edge.a == edge.b) return "joins a pose to itself";
  if (!edge.T_a_b.IsFinite()) return "has a motion that is not finite";
  if (!edge.information.allFinite()) return "has information that is not finite";
  const auto& information = edge.information;
  if (!information.isApprox(information.transpose(), 1e-6)) return "has information that is not symmetric";
  if (!IsPositiveDefinite<kPoseFreedom<Pose>>(information)) return "has information that is not positive definite";
  return "";
}

}  // namespace

template <class Pose>
std::string PoseGraphObjection(const PoseGraph<Pose>& graph) {
  for (size_t i = 0; i < graph.poses.size(); ++i) {
    if (!graph.poses[i].T_w_kf.IsFinite()) return fmt::format("pose {} is not finite", i);
  }
  for (size_t i = 0; i < graph.edges.size(); ++i) {
    const PoseGraphMotion<Pose>& edge = graph.edges[i];
    const std::string objection = EdgeObjection(edge, static_cast<int>(graph.poses.size()));
    if (!objection.empty()) return fmt::format("edge {} from pose {} to {} {}", i, edge.a, edge.b, objection);
  }
  if (graph.edges.empty()) return "no edge joins two poses";
  const std::vector<bool> constant = ConstantPoses(graph, {});
  if (std::find(constant.begin(), constant.end(), false) == constant.end()) return "no pose is free";
  return "";
}

template <class Pose>
std::vector<bool> ConstantPoses(const PoseGraph<Pose>& graph, const std::vector<bool>& rejected) {
  const size_t n = graph.poses.size();
  GraphParts parts(n);
  for (size_t i = 0; i < graph.edges.size(); ++i) {
    if (rejected.empty() || !rejected[i]) parts.Join(graph.edges[i].a, graph.edges[i].b);
  }
  std::vector<bool> constant(n, false);
  std::vector<bool> anchored(n, false);
  for (size_t i = 0; i < n; ++i) {
    if (!graph.poses[i].fixed) continue;
    constant[i] = true;
    anchored[parts.Find(static_cast<int>(i))] = true;
  }
  // A part is identified by its first pose.
  for (size_t i = 0; i < n; ++i) {
    if (parts.Find(static_cast<int>(i)) == static_cast<int>(i) && !anchored[i]) constant[i] = true;
  }
  return constant;
}

template std::string PoseGraphObjection(const PoseGraph<SE3>&);
template std::string PoseGraphObjection(const PoseGraph<SE2>&);
template std::vector<bool> ConstantPoses(const PoseGraph<SE3>&, const std::vector<bool>&);
template std::vector<bool> ConstantPoses(const PoseGraph<SE2>&, const std::vector<bool>&);

}  // namespace plslam
