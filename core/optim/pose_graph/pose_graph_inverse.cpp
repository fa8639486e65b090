#include "core/optim/pose_graph/pose_graph_inverse.h"

#include <algorithm>

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

}  // namespace plslam
