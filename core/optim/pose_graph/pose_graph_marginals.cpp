// SPDX-License-Identifier: BSD-3-Clause
#include "core/optim/pose_graph/pose_graph_marginals.h"

#include <algorithm>

#include "core/optim/pose_graph/pose_graph_check.h"

namespace plslam {

SelectedInverse::SelectedInverse(const Eigen::SparseMatrix<double>& lower) {
  ok_ = lower.rows() == 0;
  if (ok_) return;
  factor_.compute(lower);
  ok_ = factor_.info() == Eigen::Success && factor_.vectorD().minCoeff() > 0.0 && factor_.vectorD().allFinite();
  if (ok_) Fill();
}

void SelectedInverse::Fill() {
  const Sparse& L = factor_.matrixL().nestedExpression();
  const int* const start = L.outerIndexPtr();
  const int* const row = L.innerIndexPtr();
  const double* const value = L.valuePtr();
  const int n = static_cast<int>(L.cols());
  diagonal_.assign(n, 0.0);
  below_.assign(L.nonZeros(), 0.0);
  // Element of the current column of L at each row.
  std::vector<double> current(n, 0.0);
  std::vector<double> sum(n, 0.0);
  for (int j = n - 1; j >= 0; --j) {
    for (int p = start[j]; p < start[j + 1]; ++p) current[row[p]] = value[p];
    for (int p = start[j]; p < start[j + 1]; ++p) {
      const int k = row[p];
      double sum_k = value[p] * diagonal_[k];
      for (int q = start[k]; q < start[k + 1]; ++q) {
        // Rows that are not of this column have current == 0, and their sums are not looked at.
        sum_k += current[row[q]] * below_[q];
        sum[row[q]] += value[p] * below_[q];
      }
      sum[k] += sum_k;
    }
    double on_diagonal = 1.0 / factor_.vectorD()[j];
    for (int p = start[j]; p < start[j + 1]; ++p) {
      below_[p] = -sum[row[p]];
      on_diagonal -= value[p] * below_[p];
    }
    diagonal_[j] = on_diagonal;
    for (int p = start[j]; p < start[j + 1]; ++p) {
      const int k = row[p];
      current[k] = sum[k] = 0.0;
      for (int q = start[k]; q < start[k + 1]; ++q) sum[row[q]] = 0.0;
    }
  }
}

double SelectedInverse::operator()(int r, int c) const {
  const auto& place = factor_.permutationP().indices();
  const int row = std::max(place[r], place[c]);
  const int column = std::min(place[r], place[c]);
  if (row == column) return diagonal_[row];
  const Sparse& L = factor_.matrixL().nestedExpression();
  const int* const rows = L.innerIndexPtr();
  const int* const end = rows + L.outerIndexPtr()[column + 1];
  const int* const found = std::lower_bound(rows + L.outerIndexPtr()[column], end, row);
  return found != end && *found == row ? below_[found - rows] : 0.0;
}

namespace {

template <class Pose>
PoseBlockMatrix<kPoseFreedom<Pose>> Information(const PoseGraph<Pose>& graph, const std::vector<Pose>& T_w_kf,
                                                const std::vector<bool>& rejected) {
  PoseBlockMatrix<kPoseFreedom<Pose>> H(ConstantPoses(graph, rejected));
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
