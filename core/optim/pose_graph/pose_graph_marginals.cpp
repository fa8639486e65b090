#include "core/optim/pose_graph/pose_graph_marginals.h"

#include "core/optim/pose_graph/pose_graph_check.h"

namespace plslam {
namespace {

template <class Pose>
PoseBlockMatrix<kPoseFreedom<Pose>> Information(const PoseGraph<Pose>& graph, const std::vector<Pose>& T_w_kf,
                                                const std::vector<bool>& rejected) {
  PoseBlockMatrix<kPoseFreedom<Pose>> H(HeldPoses(graph, rejected));
  for (size_t i = 0; i < graph.edges.size(); ++i) {
    if (rejected[i]) continue;
    const PoseGraphMotion<Pose>& edge = graph.edges[i];
    const PoseEdgeError<Pose> error = PoseGroup<Pose>::Error(edge.T_a_b, T_w_kf[edge.a], T_w_kf[edge.b]);
    H.Add(edge.a, edge.a, error.by_a.transpose() * edge.information * error.by_a);
    H.Add(edge.b, edge.b, error.by_b.transpose() * edge.information * error.by_b);
    H.Add(edge.a, edge.b, error.by_a.transpose() * edge.information * error.by_b);
  }
  return H;
}

}  // namespace

template <class Pose>
PoseGraphMarginals<Pose>::PoseGraphMarginals(const PoseGraph<Pose>& graph, const std::vector<Pose>& T_w_kf,
                                             const std::vector<bool>& rejected)
    : blocks_(Information(graph, T_w_kf, rejected)), inverse_(blocks_.Build()) {}

template <class Pose>
PoseMatrix<Pose> PoseGraphMarginals<Pose>::Block(int a, int b) const {
  PoseMatrix<Pose> block = PoseMatrix<Pose>::Zero();
  const int row = blocks_.column(a);
  const int column = blocks_.column(b);
  if (row < 0 || column < 0) return block;
  for (int j = 0; j < kFreedom; ++j) {
    for (int i = 0; i < kFreedom; ++i) block(i, j) = inverse_(kFreedom * row + i, kFreedom * column + j);
  }
  return block;
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
