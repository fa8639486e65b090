// SPDX-License-Identifier: BSD-3-Clause
#include "core/optim/pose_graph/pose_graph_rejection.h"

#include "core/geometry/symmetric.h"
#include "core/optim/pose_graph/pose_graph_marginals.h"

namespace plslam {
namespace {

// Share of an edge's information that others must contribute in a direction for the edge to be predicted there; below
// it, the difference is rounding error. The only edge between two parts may still seem predicted; the solve without it
// decides.
constexpr double kPredicted = 1e-12;

template <class Pose>
double DeletionGain(const PoseGraphMotion<Pose>& edge, const std::vector<Pose>& T_w_kf,
                    const PoseGraphMarginals<Pose>& marginals) {
  constexpr int kFreedom = kPoseFreedom<Pose>;
  const PoseEdgeError<Pose> error = PoseGroup<Pose>::Error(edge.T_a_b, T_w_kf[edge.a], T_w_kf[edge.b]);
  // Solved graphs have positive definite information only.
  const PoseMatrix<Pose> whitening = CholeskyFactor<kFreedom>(edge.information).value().transpose();
  Eigen::Matrix<double, kFreedom, 2 * kFreedom> J;
  J << whitening * error.by_a, whitening * error.by_b;
  const PoseMatrix<Pose> left = PoseMatrix<Pose>::Identity() - J * marginals.OfEdge(edge) * J.transpose();
  const auto [values, vectors] = EigenOf<kFreedom>(0.5 * (left + left.transpose()));
  const auto r = (vectors.transpose() * whitening * error.e).eval();
  double gain = 0.0;
  for (int i = 0; i < kFreedom; ++i) {
    if (values[i] > kPredicted) gain += r[i] * r[i] / values[i];
  }
  return gain;
}

}  // namespace

template <class Pose>
std::vector<double> DeletionGains(const PoseGraph<Pose>& graph, const std::vector<Pose>& T_w_kf,
                                  const std::vector<bool>& rejected) {
  const PoseGraphMarginals<Pose> marginals(graph, T_w_kf, rejected);
  if (!marginals.ok()) return {};
  std::vector<double> gains(graph.edges.size(), 0.0);
  for (size_t i = 0; i < graph.edges.size(); ++i) {
    if (graph.edges[i].robust && !rejected[i]) gains[i] = DeletionGain(graph.edges[i], T_w_kf, marginals);
  }
  return gains;
}

template std::vector<double> DeletionGains(const PoseGraph<SE3>&, const std::vector<SE3>&, const std::vector<bool>&);
template std::vector<double> DeletionGains(const PoseGraph<SE2>&, const std::vector<SE2>&, const std::vector<bool>&);

}  // namespace plslam
