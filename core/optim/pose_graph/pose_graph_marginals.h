// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/SparseCholesky>

#include <vector>

#include "core/optim/pose_graph/pose_graph_blocks.h"
#include "core/optim/pose_graph/pose_graph_group.h"

namespace plslam {

/// Chosen elements of the inverse of a sparse symmetric positive definite matrix, without the rest of it: those where
/// the matrix itself, or its Cholesky factor L D L^T, has an element. Recursion from the last column to the first
/// (Takahashi, Fagan, Chin 1973): Z = D^-1 L^-1 + (I - L^T) Z, in which each column needs only chosen elements of
/// later ones. Costs about as much as the factorisation.
class SelectedInverse {
 public:
  /// Of the lower triangle of a symmetric matrix.
  explicit SelectedInverse(const Eigen::SparseMatrix<double>& lower);

  /// False where the matrix is not positive definite; there are no elements then.
  bool ok() const { return ok_; }

  /// Where the matrix has an element of its own, or on the diagonal.
  double operator()(int row, int column) const;

 private:
  void Fill();

  using Sparse = Eigen::SparseMatrix<double>;
  Eigen::SimplicialLDLT<Sparse> factor_;
  bool ok_ = false;
  std::vector<double> diagonal_;
  /// Beside the elements of L.
  std::vector<double> below_;
};

/// Marginal covariances of the right perturbations at given poses, from the edges that are not rejected.
template <class Pose>
class PoseGraphMarginals {
 public:
  static constexpr int kFreedom = kPoseFreedom<Pose>;
  using JointMatrix = Eigen::Matrix<double, 2 * kFreedom, 2 * kFreedom>;

  PoseGraphMarginals(const PoseGraph<Pose>& graph, const std::vector<Pose>& T_w_kf,
                     const std::vector<bool>& rejected);

  bool ok() const { return inverse_.ok(); }

  /// Zero for constant poses.
  PoseMatrix<Pose> OfPose(int pose) const { return Block(pose, pose); }
  /// Of both ends of an edge that is not rejected.
  JointMatrix OfEdge(const PoseGraphMotion<Pose>& edge) const;

 private:
  using Blocks = PoseBlockMatrix<kFreedom>;

  PoseMatrix<Pose> Block(int a, int b) const;

  Blocks blocks_;
  SelectedInverse inverse_;
};

}  // namespace plslam
