// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <numeric>
#include <vector>

#include <Eigen/SparseCore>

namespace plslam {

/// Connected parts of a graph, each identified by its first pose (union-find).
class GraphParts {
 public:
  explicit GraphParts(size_t n) : parent_(n) { std::iota(parent_.begin(), parent_.end(), 0); }

  int Find(int i) {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }

  /// Returns false if they are the same part already.
  bool Join(int a, int b) {
    a = Find(a);
    b = Find(b);
    parent_[std::max(a, b)] = std::min(a, b);
    return a != b;
  }

 private:
  std::vector<int> parent_;
};

/// A sparse symmetric matrix of N x N blocks, one row and column of blocks for each pose that is not constant, built by
/// adding blocks. Only its lower triangle is stored.
template <int N>
class PoseBlockMatrix {
 public:
  using Block = Eigen::Matrix<double, N, N>;

  explicit PoseBlockMatrix(const std::vector<bool>& constant) : column_(constant.size(), -1) {
    for (size_t i = 0; i < constant.size(); ++i) {
      if (!constant[i]) column_[i] = size_++;
    }
  }

  /// Index of the pose among the blocks; -1 if it is constant.
  int column(int pose) const { return column_[pose]; }
  /// Number of scalar rows.
  int rows() const { return N * size_; }

  /// Adds to the block of (a, b) and, by symmetry, to that of (b, a). Ignores blocks of constant poses.
  void Add(int a, int b, const Block& block) {
    const int row = column_[a];
    const int column = column_[b];
    if (row < 0 || column < 0) return;
    for (int j = 0; j < N; ++j) {
      for (int i = row == column ? j : 0; i < N; ++i) {
        const int r = N * row + i;
        const int c = N * column + j;
        triplets_.emplace_back(std::max(r, c), std::min(r, c), block(i, j));
      }
    }
  }

  Eigen::SparseMatrix<double> Build() const {
    Eigen::SparseMatrix<double> matrix(rows(), rows());
    matrix.setFromTriplets(triplets_.begin(), triplets_.end());
    return matrix;
  }

 private:
  std::vector<int> column_;
  int size_ = 0;
  std::vector<Eigen::Triplet<double>> triplets_;
};

}  // namespace plslam
