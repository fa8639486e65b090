// SPDX-License-Identifier: BSD-3-Clause
#include "core/optim/pose_graph/pose_graph_marginals.h"

#include "core/optim/pose_graph/pose_graph_check.h"

namespace plslam {
namespace {

template <class Pose>
SymmetricBlocks<kPoseFreedom<Pose>> Information(const PoseGraph<Pose>& graph, const std::vector<Pose>& T_w_kf,
                                                const std::vector<bool>& rejected, const std::vector<int>& columns,
                                                int n_columns) {
  SymmetricBlocks<kPoseFreedom<Pose>> H(n_columns);
  for (size_t i = 0; i < graph.edges.size(); ++i) {
    if (rejected[i]) continue;
    const PoseGraphMotion<Pose>& edge = graph.edges[i];
    const PoseEdgeError<Pose> error = PoseGroup<Pose>::Error(edge.T_a_b, T_w_kf[edge.a], T_w_kf[edge.b]);
    const int a = columns[edge.a];
    const int b = columns[edge.b];
    if (a >= 0) H.diagonal[static_cast<size_t>(a)] += error.by_a.transpose() * edge.information * error.by_a;
    if (b >= 0) H.diagonal[static_cast<size_t>(b)] += error.by_b.transpose() * edge.information * error.by_b;
    if (a < 0 || b < 0) continue;
    if (a < b) {
      H.Below(a, b) += error.by_b.transpose() * edge.information * error.by_a;
    } else {
      H.Below(b, a) += error.by_a.transpose() * edge.information * error.by_b;
    }
  }
  return H;
}

}  // namespace

template <class Pose>
PoseGraphMarginals<Pose>::PoseGraphMarginals(const PoseGraph<Pose>& graph, const std::vector<Pose>& T_w_kf,
                                             const std::vector<bool>& rejected)
    : column_(graph.poses.size(), -1) {
  const std::vector<bool> constant = ConstantPoses(graph, rejected);
  int n_columns = 0;
  for (size_t i = 0; i < column_.size(); ++i) {
    if (!constant[i]) column_[i] = n_columns++;
  }
  ok_ = cholesky_.Factorise(Information(graph, T_w_kf, rejected, column_, n_columns));
  if (ok_) cholesky_.Invert();
}

template <class Pose>
PoseMatrix<Pose> PoseGraphMarginals<Pose>::Block(int a, int b) const {
  const int row = column_[a];
  const int column = column_[b];
  return row < 0 || column < 0 ? PoseMatrix<Pose>::Zero() : cholesky_.Inverse(row, column);
}

template <class Pose>
typename PoseGraphMarginals<Pose>::JointMatrix PoseGraphMarginals<Pose>::OfEdge(
    const PoseGraphMotion<Pose>& edge) const {
  const PoseMatrix<Pose> across = Block(edge.a, edge.b);
  JointMatrix joint;
  joint << Block(edge.a, edge.a), across, across.transpose(), Block(edge.b, edge.b);
  return joint;
}

template class PoseGraphMarginals<SE3>;
template class PoseGraphMarginals<SE2>;

}  // namespace plslam
