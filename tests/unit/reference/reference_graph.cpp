// SPDX-License-Identifier: BSD-3-Clause
#include "tests/unit/reference/reference_graph.h"

#include "core/optim/reference/motion_functor.h"

namespace plslam::test {

ReferenceSpaceGraph::ReferenceSpaceGraph(const PoseGraph<SE3>& graph, const std::vector<SE3>& T_w_kf)
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

SE3 ReferenceSpaceGraph::T_w_kf(size_t i) const { return reference::MovedPose(start_[i], x_[i].data()); }

ReferencePlanarGraph::ReferencePlanarGraph(const PoseGraph<SE2>& graph, const std::vector<SE2>& T_w_kf) {
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

}  // namespace plslam::test
