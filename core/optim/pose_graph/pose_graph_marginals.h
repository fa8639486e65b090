#pragma once

#include <vector>

#include "core/optim/pose_graph/pose_graph_blocks.h"
#include "core/optim/pose_graph/pose_graph_group.h"
#include "core/optim/pose_graph/pose_graph_inverse.h"

namespace plslam {

/// Marginal covariances of the right perturbations at given poses, from the edges that are not rejected.
template <class Pose>
class PoseGraphMarginals {
 public:
  static constexpr int kFreedom = kPoseFreedom<Pose>;
  using JointMatrix = Eigen::Matrix<double, 2 * kFreedom, 2 * kFreedom>;

  PoseGraphMarginals(const PoseGraph<Pose>& graph, const std::vector<Pose>& T_w_kf,
                     const std::vector<bool>& rejected);

  bool ok() const { return inverse_.ok(); }

  /// Zero for held poses.
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
