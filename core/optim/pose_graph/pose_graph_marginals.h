// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "core/optim/pose_graph/pose_graph_group.h"
#include "core/optim/solver/block_cholesky.h"

namespace plslam {

/// Marginal covariances of the right perturbations at given poses, from the edges that are not rejected: blocks of the
/// inverse information (`BlockCholesky::Invert`).
template <class Pose>
class PoseGraphMarginals {
 public:
  static constexpr int kFreedom = kPoseFreedom<Pose>;
  using JointMatrix = Eigen::Matrix<double, 2 * kFreedom, 2 * kFreedom>;

  PoseGraphMarginals(const PoseGraph<Pose>& graph, const std::vector<Pose>& T_w_kf,
                     const std::vector<bool>& rejected);

  /// False if the information is not positive definite; there are no marginals then.
  bool ok() const { return ok_; }

  /// Zero for constant poses.
  PoseMatrix<Pose> OfPose(int pose) const { return Block(pose, pose); }
  /// Joint covariance of both ends of an edge that is not rejected.
  JointMatrix OfEdge(const PoseGraphMotion<Pose>& edge) const;

 private:
  PoseMatrix<Pose> Block(int a, int b) const;

  std::vector<int> column_;  ///< of each pose; -1 if it is constant
  BlockCholesky<kFreedom> cholesky_;
  bool ok_ = false;
};

}  // namespace plslam
