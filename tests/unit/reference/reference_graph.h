// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include <ceres/ceres.h>

#include "core/optim/pose_graph/pose_graph.h"
#include "core/optim/reference/motion_functor.h"

namespace plslam::test {

/// A pose graph as a Ceres problem: the first pose is constant, and poses start where they are given.
class ReferenceSpaceGraph {
 public:
  ReferenceSpaceGraph(const PoseGraph<SE3>& graph, const std::vector<SE3>& T_w_kf)
      : start_(T_w_kf), x_(T_w_kf.size(), Vector6d::Zero()) {
    for (const auto& edge : graph.edges) {
      const auto a = static_cast<size_t>(edge.a), b = static_cast<size_t>(edge.b);
      using Edge = reference::EdgeFunctor;
      auto* functor = new Edge(edge.T_a_b, edge.information, T_w_kf[a], T_w_kf[b]);
      problem_.AddResidualBlock(new ceres::AutoDiffCostFunction<Edge, 6, 6, 6>(functor), nullptr, x_[a].data(),
                                x_[b].data());
    }
    problem_.SetParameterBlockConstant(x_[0].data());
  }

  ceres::Problem& problem() { return problem_; }
  SE3 T_w_kf(size_t i) const { return reference::MovedPose(start_[i], x_[i].data()); }

 private:
  std::vector<SE3> start_;
  std::vector<Vector6d> x_;
  ceres::Problem problem_;
};

/// The same in the plane.
class ReferencePlanarGraph {
 public:
  ReferencePlanarGraph(const PoseGraph<SE2>& graph, const std::vector<SE2>& T_w_kf) {
    for (const SE2& T : T_w_kf) x_.emplace_back(T.translation().x(), T.translation().y(), T.angle());
    for (const auto& edge : graph.edges) {
      const auto a = static_cast<size_t>(edge.a), b = static_cast<size_t>(edge.b);
      using Edge = reference::PlanarEdgeFunctor;
      auto* functor = new Edge(edge.T_a_b.angle(), edge.T_a_b.translation(), edge.information);
      problem_.AddResidualBlock(new ceres::AutoDiffCostFunction<Edge, 3, 3, 3>(functor), nullptr, x_[a].data(),
                                x_[b].data());
    }
    problem_.SetParameterBlockConstant(x_[0].data());
  }

  ceres::Problem& problem() { return problem_; }
  SE2 T_w_kf(size_t i) const { return SE2(x_[i].z(), x_[i].head<2>()); }

 private:
  std::vector<Eigen::Vector3d> x_;
  ceres::Problem problem_;
};

template <class Pose>
struct ReferenceGraphOf;
template <>
struct ReferenceGraphOf<SE3> {
  using Type = ReferenceSpaceGraph;
};
template <>
struct ReferenceGraphOf<SE2> {
  using Type = ReferencePlanarGraph;
};
template <class Pose>
using ReferenceGraph = typename ReferenceGraphOf<Pose>::Type;

}  // namespace plslam::test
