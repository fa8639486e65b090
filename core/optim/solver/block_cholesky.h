// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <utility>
#include <vector>

#include <Eigen/Core>

namespace plslam {

/// A sparse symmetric matrix of N x N blocks, N = 3 or 6: all diagonal blocks, and the blocks below the diagonal that
/// were accessed.
template <int N>
struct SymmetricBlocks {
  using Block = Eigen::Matrix<double, N, N>;

  explicit SymmetricBlocks(int size = 0)
      : diagonal(static_cast<size_t>(size), Block::Zero()), rows(static_cast<size_t>(size)) {}

  /// Returns the block in row `later` and column `earlier` (< later), created if it is missing. The reference is valid
  /// until the next block is created.
  Block& Below(int earlier, int later);

  void SetZero();
  /// Copies the values of `other`, of the same size; blocks that only this one has become zero, and stay.
  void Assign(const SymmetricBlocks& other);

  std::vector<Block> diagonal;
  /// By row: columns of its blocks below the diagonal, ascending, with their indices in `below`.
  std::vector<std::vector<std::pair<int, size_t>>> rows;
  std::vector<Block> below;
};

/// Cholesky factor L L^T of a positive definite `SymmetricBlocks`, rows and columns reordered so that little of L is
/// filled (approximate minimum degree: P. Amestoy, T. Davis, I. Duff, 1996). The column structure of L follows from
/// the elimination tree (T. Davis, "Direct Methods for Sparse Linear Systems", 2006, ch. 4). Sums are taken in one
/// order, so equal input gives equal output on every machine.
template <int N>
class BlockCholesky {
 public:
  /// Returns false if the matrix is not positive definite. The symbolic analysis is reused while the number of blocks
  /// is the same as before: blocks are never removed.
  bool Factorise(const SymmetricBlocks<N>& matrix);

  /// Returns x with A x = b.
  Eigen::VectorXd Solve(const Eigen::VectorXd& b) const;

  /// Computes the blocks of the inverse of A where A or L has a block. Recursion from the last column to the first
  /// (K. Takahashi, J. Fagan, M. Chin, 1973): Z = L^-T L^-1 restricted to that pattern needs only blocks of later
  /// columns. Costs about as much as the factorisation.
  void Invert();
  /// Returns a block of the inverse, after `Invert`; zero if it was not computed.
  Eigen::Matrix<double, N, N> Inverse(int row, int column) const;

  /// Number of blocks of L below the diagonal.
  size_t size() const { return blocks_.size(); }

 private:
  using Block = Eigen::Matrix<double, N, N>;

  void Analyse(const SymmetricBlocks<N>& matrix);
  void Fill(const SymmetricBlocks<N>& matrix);
  void InvertColumn(size_t column);
  bool FactoriseColumn(size_t column);
  size_t IndexOf(int row, size_t column) const;

  size_t n_analysed_ = 0;
  std::vector<int> place_of_;  ///< index in L of a row of the matrix
  /// Rows below the diagonal of each column of L, ascending, from first_[column] up to first_[column + 1].
  std::vector<size_t> first_;
  std::vector<int> rows_;
  std::vector<Block> diagonal_;  ///< lower triangular
  std::vector<Block> blocks_;
  std::vector<Block> inverse_diagonal_;
  std::vector<Block> inverse_blocks_;  ///< same indices as `blocks_`
};

}  // namespace plslam
