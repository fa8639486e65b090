// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "core/geometry/se3.h"

namespace plslam {

/// The information matrix of the free poses once landmarks are eliminated: 6 x 6 blocks of a symmetric matrix, of
/// which the upper ones are kept and only where two poses share a landmark.
class ReducedInformation {
 public:
  /// Starts with next to nothing on the diagonal (a kilometre, ten turns), so that what nobody saw is very uncertain.
  explicit ReducedInformation(int pose_count);

  /// Adds to block (i, j); i <= j.
  void Add(int i, int j, const Matrix6d& block) { Block(i, j) += block; }

  /// Diagonal blocks of the inverse; as of what nobody saw should the matrix not be positive definite.
  std::vector<Matrix6d> Covariances() const;

 private:
  Matrix6d& Block(int i, int j);
  std::vector<Matrix6d> DenseCovariances() const;
  std::vector<Matrix6d> SparseCovariances() const;

  int pose_count_;
  std::vector<std::map<int, Matrix6d>> rows_;
};

}  // namespace plslam
