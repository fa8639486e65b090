// SPDX-License-Identifier: BSD-3-Clause
#include "core/optim/solver/block_cholesky.h"

#include <Eigen/Cholesky>
#include <Eigen/OrderingMethods>
#include <Eigen/SparseCore>

#include <algorithm>

namespace plslam {
namespace {

/// Returns the new index of each row.
template <int N>
std::vector<int> FillReducingOrder(const SymmetricBlocks<N>& matrix) {
  const auto n = static_cast<int>(matrix.rows.size());
  std::vector<Eigen::Triplet<double>> pattern;
  for (int row = 0; row < n; ++row) {
    pattern.emplace_back(row, row, 1.0);
    for (const auto& [column, place] : matrix.rows[static_cast<size_t>(row)]) {
      pattern.emplace_back(row, column, 1.0);
      pattern.emplace_back(column, row, 1.0);
    }
  }
  Eigen::SparseMatrix<double> graph(n, n);
  graph.setFromTriplets(pattern.begin(), pattern.end());
  Eigen::AMDOrdering<int>::PermutationType order;
  Eigen::AMDOrdering<int>()(graph, order);
  // Row order.indices()[k] of the matrix gets index k.
  std::vector<int> place_of(static_cast<size_t>(n));
  for (int k = 0; k < n; ++k) place_of[static_cast<size_t>(order.indices()[k])] = k;
  return place_of;
}

}  // namespace

template <int N>
Eigen::Matrix<double, N, N>& SymmetricBlocks<N>::Below(int earlier, int later) {
  auto& row = rows[static_cast<size_t>(later)];
  const auto found = std::lower_bound(row.begin(), row.end(), earlier,
                                      [](const std::pair<int, size_t>& entry, int id) { return entry.first < id; });
  if (found != row.end() && found->first == earlier) return below[found->second];
  row.insert(found, {earlier, below.size()});
  return below.emplace_back(Block::Zero());
}

template <int N>
void SymmetricBlocks<N>::SetZero() {
  for (Block& block : diagonal) block.setZero();
  for (Block& block : below) block.setZero();
}

template <int N>
void SymmetricBlocks<N>::Assign(const SymmetricBlocks& other) {
  diagonal = other.diagonal;
  for (Block& block : below) block.setZero();
  for (size_t row = 0; row < other.rows.size(); ++row) {
    for (const auto& [column, place] : other.rows[row]) Below(column, static_cast<int>(row)) = other.below[place];
  }
}

template <int N>
void BlockCholesky<N>::Analyse(const SymmetricBlocks<N>& matrix) {
  const size_t n = matrix.rows.size();
  place_of_ = FillReducingOrder(matrix);
  // Rows of each column: those of the matrix, and then those inherited from its children in the elimination tree.
  std::vector<std::vector<int>> columns(n);
  for (size_t row = 0; row < n; ++row) {
    for (const auto& [column, place] : matrix.rows[row]) {
      const auto [first, last] = std::minmax(place_of_[row], place_of_[static_cast<size_t>(column)]);
      columns[static_cast<size_t>(first)].push_back(last);
    }
  }
  first_.assign(1, 0);
  rows_.clear();
  for (size_t column = 0; column < n; ++column) {
    std::vector<int>& rows = columns[column];
    std::sort(rows.begin(), rows.end());
    rows.erase(std::unique(rows.begin(), rows.end()), rows.end());
    rows_.insert(rows_.end(), rows.begin(), rows.end());
    first_.push_back(rows_.size());
    if (rows.empty()) continue;
    std::vector<int>& parent = columns[static_cast<size_t>(rows.front())];
    parent.insert(parent.end(), rows.begin() + 1, rows.end());
    rows = {};
  }
  diagonal_.resize(n);
  blocks_.resize(rows_.size());
}

/// Returns the index of a block in `blocks_`, or where it would be inserted.
template <int N>
size_t BlockCholesky<N>::IndexOf(int row, size_t column) const {
  const auto begin = rows_.begin() + static_cast<std::ptrdiff_t>(first_[column]);
  const auto end = rows_.begin() + static_cast<std::ptrdiff_t>(first_[column + 1]);
  return static_cast<size_t>(std::lower_bound(begin, end, row) - rows_.begin());
}

template <int N>
void BlockCholesky<N>::Fill(const SymmetricBlocks<N>& matrix) {
  for (Block& block : blocks_) block.setZero();
  for (size_t row = 0; row < matrix.rows.size(); ++row) {
    const int place = place_of_[row];
    diagonal_[static_cast<size_t>(place)] = matrix.diagonal[row];
    for (const auto& [column, block] : matrix.rows[row]) {
      const int other = place_of_[static_cast<size_t>(column)];
      if (place > other) {
        blocks_[IndexOf(place, static_cast<size_t>(other))] = matrix.below[block];
      } else {
        blocks_[IndexOf(other, static_cast<size_t>(place))] = matrix.below[block].transpose();
      }
    }
  }
}

/// Factorises a column, to which all earlier columns have contributed, and subtracts its contribution to later ones.
template <int N>
bool BlockCholesky<N>::FactoriseColumn(size_t column) {
  const Eigen::LLT<Block> root(diagonal_[column]);
  // NaN propagates to the last element of the factor.
  if (root.info() != Eigen::Success || !(root.matrixLLT()(N - 1, N - 1) > 0.0)) return false;
  diagonal_[column] = root.matrixL();
  const Block inverse_root = root.matrixL().solve(Block::Identity());
  const size_t begin = first_[column];
  const size_t end = first_[column + 1];
  for (size_t k = begin; k < end; ++k) blocks_[k] = (blocks_[k] * inverse_root.transpose()).eval();
  for (size_t k = begin; k < end; ++k) {
    const auto target = static_cast<size_t>(rows_[k]);
    const Block transposed = blocks_[k].transpose();
    diagonal_[target].noalias() -= blocks_[k] * transposed;
    // The rows of this column are a subset of those of the target, and both ascend.
    size_t place = first_[target];
    for (size_t j = k + 1; j < end; ++j) {
      while (rows_[place] != rows_[j]) ++place;
      blocks_[place].noalias() -= blocks_[j] * transposed;
    }
  }
  return true;
}

template <int N>
bool BlockCholesky<N>::Factorise(const SymmetricBlocks<N>& matrix) {
  if (place_of_.size() != matrix.rows.size() || n_analysed_ != matrix.below.size()) {
    Analyse(matrix);
    n_analysed_ = matrix.below.size();
  }
  Fill(matrix);
  for (size_t column = 0; column < diagonal_.size(); ++column) {
    if (!FactoriseColumn(column)) return false;
  }
  return true;
}

/// Requires the inverse blocks of all later columns.
template <int N>
void BlockCholesky<N>::InvertColumn(size_t column) {
  const size_t begin = first_[column];
  const size_t end = first_[column + 1];
  const Block inverse_root = diagonal_[column].template triangularView<Eigen::Lower>().solve(Block::Identity());
  std::vector<Block> scaled(end - begin);
  for (size_t k = begin; k < end; ++k) scaled[k - begin].noalias() = blocks_[k] * inverse_root;
  for (size_t k = begin; k < end; ++k) inverse_blocks_[k].setZero();
  for (size_t k = begin; k < end; ++k) {
    const auto later = static_cast<size_t>(rows_[k]);
    inverse_blocks_[k].noalias() -= inverse_diagonal_[later] * scaled[k - begin];
    // The rows of this column are a subset of those of the later one, and both ascend.
    size_t place = first_[later];
    for (size_t j = k + 1; j < end; ++j) {
      while (rows_[place] != rows_[j]) ++place;
      inverse_blocks_[j].noalias() -= inverse_blocks_[place] * scaled[k - begin];
      inverse_blocks_[k].noalias() -= inverse_blocks_[place].transpose() * scaled[j - begin];
    }
  }
  Block on_diagonal = inverse_root.transpose() * inverse_root;
  for (size_t k = begin; k < end; ++k) on_diagonal.noalias() -= scaled[k - begin].transpose() * inverse_blocks_[k];
  inverse_diagonal_[column] = 0.5 * (on_diagonal + on_diagonal.transpose());
}

template <int N>
void BlockCholesky<N>::Invert() {
  inverse_diagonal_.resize(diagonal_.size());
  inverse_blocks_.resize(blocks_.size());
  for (size_t column = diagonal_.size(); column-- > 0;) InvertColumn(column);
}

template <int N>
Eigen::Matrix<double, N, N> BlockCholesky<N>::Inverse(int row, int column) const {
  const int place = place_of_[static_cast<size_t>(row)];
  const int other = place_of_[static_cast<size_t>(column)];
  if (place == other) return inverse_diagonal_[static_cast<size_t>(place)];
  const auto earlier = static_cast<size_t>(std::min(place, other));
  const int later = std::max(place, other);
  const size_t found = IndexOf(later, earlier);
  if (found == first_[earlier + 1] || rows_[found] != later) return Block::Zero();
  return place > other ? inverse_blocks_[found] : Block(inverse_blocks_[found].transpose());
}

template <int N>
Eigen::VectorXd BlockCholesky<N>::Solve(const Eigen::VectorXd& b) const {
  const size_t n = diagonal_.size();
  std::vector<Eigen::Matrix<double, N, 1>> x(n);
  for (size_t row = 0; row < n; ++row) {
    x[static_cast<size_t>(place_of_[row])] = b.template segment<N>(N * static_cast<Eigen::Index>(row));
  }
  for (size_t column = 0; column < n; ++column) {
    diagonal_[column].template triangularView<Eigen::Lower>().solveInPlace(x[column]);
    for (size_t k = first_[column]; k < first_[column + 1]; ++k) {
      x[static_cast<size_t>(rows_[k])].noalias() -= blocks_[k] * x[column];
    }
  }
  for (size_t column = n; column-- > 0;) {
    for (size_t k = first_[column]; k < first_[column + 1]; ++k) {
      x[column].noalias() -= blocks_[k].transpose() * x[static_cast<size_t>(rows_[k])];
    }
    diagonal_[column].template triangularView<Eigen::Lower>().transpose().solveInPlace(x[column]);
  }
  Eigen::VectorXd solution(b.size());
  for (size_t row = 0; row < n; ++row) {
    solution.template segment<N>(N * static_cast<Eigen::Index>(row)) = x[static_cast<size_t>(place_of_[row])];
  }
  return solution;
}

template struct SymmetricBlocks<3>;
template struct SymmetricBlocks<6>;
template class BlockCholesky<3>;
template class BlockCholesky<6>;

}  // namespace plslam
