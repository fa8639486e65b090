// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <utility>
#include <vector>

#include <Eigen/Core>

namespace plslam {

/// A symmetric matrix of N x N blocks, N = 3 or 6, of which most are zero: those on the diagonal, and those below it
/// that have been asked for.
template <int N>
struct SymmetricBlocks {
  using Block = Eigen::Matrix<double, N, N>;

  explicit SymmetricBlocks(int size = 0)
      : diagonal(static_cast<size_t>(size), Block::Zero()), rows(static_cast<size_t>(size)) {}

  /// The block in row `later` and column `earlier` (< later), which is there from now on. The reference holds until
  /// another one is asked for for the first time.
  Block& Below(int earlier, int later);

  void SetZero();
  /// The values of `other`, of the same size; blocks that only this one has become zero, and stay.
  void Assign(const SymmetricBlocks& other);

  std::vector<Block> diagonal;
  /// Of each row the columns of its blocks below the diagonal, ascending, with their places in `below`.
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
  /// False where the matrix is not positive definite. What was found out about the structure is used again as long as
  /// it has as many blocks as before: they are never taken away.
  bool Factorise(const SymmetricBlocks<N>& matrix);

  /// x of A x = b.
  Eigen::VectorXd Solve(const Eigen::VectorXd& b) const;

  /// Computes those blocks of the inverse of A where A, or L, has one, without the rest of it. Recursion from the last
  /// column to the first (K. Takahashi, J. Fagan, M. Chin, 1973): Z = L^-T L^-1 restricted to that pattern needs only
  /// blocks of later columns. Costs about as much as the factorisation.
  void Invert();
  /// Of the inverse, after `Invert`; zero where it was not computed.
  Eigen::Matrix<double, N, N> Inverse(int row, int column) const;

  /// Blocks of L below the diagonal.
  size_t size() const { return blocks_.size(); }

 private:
  using Block = Eigen::Matrix<double, N, N>;

  void Analyse(const SymmetricBlocks<N>& matrix);
  void Fill(const SymmetricBlocks<N>& matrix);
  void InvertColumn(size_t column);
  bool FactoriseColumn(size_t column);
  size_t PlaceOf(int row, size_t column) const;

  size_t n_analysed_ = 0;
  std::vector<int> place_of_;  ///< of a row of the matrix in L
  /// Of each column of L its rows below the diagonal, ascending, from first_[column] to first_[column + 1].
  std::vector<size_t> first_;
  std::vector<int> rows_;
  std::vector<Block> diagonal_;  ///< lower triangular
  std::vector<Block> blocks_;
  std::vector<Block> inverse_diagonal_;
  std::vector<Block> inverse_blocks_;  ///< beside `blocks_`
};

}  // namespace plslam
