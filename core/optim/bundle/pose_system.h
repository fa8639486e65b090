// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <vector>

#include <Eigen/Core>

#include "core/geometry/se3.h"
#include "core/optim/solver/block_cholesky.h"

namespace plslam {

/// Normal equations H x = -g of the free poses, six rows for each. Only blocks of the symmetric H on and below the
/// diagonal are stored: all for few poses; for many, where most pairs share no landmark, only those that were accessed.
class PoseSystem {
 public:
  using Block = Eigen::Map<Matrix6d, Eigen::Unaligned, Eigen::OuterStride<>>;

  enum class Storage { kDense, kSparse };
  PoseSystem(int pose_count, Storage storage);

  void SetZero();
  /// Copies the values of `other`; blocks that only this one has become zero, and stay.
  void Assign(const PoseSystem& other);

  Block Diagonal(int pose) {
    if (is_dense_) return DenseBlock(pose, pose);
    return SparseBlock(blocks_.diagonal[static_cast<size_t>(pose)]);
  }
  auto Gradient(int pose) { return g_.segment<6>(6 * pose); }
  /// Block of two different poses, in the later one's rows.
  Block Below(int earlier, int later) {
    if (is_dense_) return DenseBlock(later, earlier);
    return SparseBlock(blocks_.Below(earlier, later));
  }

  const Eigen::VectorXd& g() const { return g_; }
  Eigen::VectorXd DiagonalValues() const;
  void AddToDiagonal(const Eigen::VectorXd& values);

  /// Returns x; nullopt if H is not positive definite. Overwrites a dense H.
  std::optional<Eigen::VectorXd> Solve();

 private:
  Block DenseBlock(int row, int column) {
    return Block(H_.data() + 6 * row + 6 * column * H_.rows(), Eigen::OuterStride<>(H_.rows()));
  }
  static Block SparseBlock(Matrix6d& block) { return Block(block.data(), Eigen::OuterStride<>(6)); }

  bool is_dense_;
  Eigen::VectorXd g_;
  Eigen::MatrixXd H_;
  SymmetricBlocks<6> blocks_;
  BlockCholesky<6> cholesky_;
};

}  // namespace plslam
