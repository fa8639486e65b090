// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "core/geometry/se3.h"

namespace plslam {

/// Information matrix of the free poses after elimination of the landmarks: a symmetric matrix of 6 x 6 blocks. Only
/// upper blocks are stored, of pairs of poses that share a landmark.
class ReducedInformation {
 public:
  /// Starts with a negligible diagonal (a kilometre, ten turns), so that poses without observations are very uncertain.
  explicit ReducedInformation(int pose_count);

  /// Adds to block (i, j); i <= j.
  void Add(int i, int j, const Matrix6d& block) { Block(i, j) += block; }

  /// Returns the diagonal blocks of the inverse; those of unobserved poses if the matrix is not positive definite.
  std::vector<Matrix6d> Covariances() const;

 private:
  Matrix6d& Block(int i, int j);
  std::vector<Matrix6d> DenseCovariances() const;
  std::vector<Matrix6d> SparseCovariances() const;

  int pose_count_;
  std::vector<std::map<int, Matrix6d>> rows_;
};

}  // namespace plslam
