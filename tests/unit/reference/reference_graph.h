// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include <ceres/ceres.h>

#include "core/optim/pose_graph/pose_graph.h"

namespace plslam::test {

/// A pose graph as a Ceres problem: the first pose is constant, and poses start where they are given.
class ReferenceSpaceGraph {
 public:
  ReferenceSpaceGraph(const PoseGraph<SE3>& graph, const std::vector<SE3>& T_w_kf);

  ceres::Problem& problem() { return problem_; }
  SE3 T_w_kf(size_t i) const;

 private:
  std::vector<SE3> start_;
  std::vector<Vector6d> x_;
  ceres::Problem problem_;
};

/// The same in the plane.
class ReferencePlanarGraph {
 public:
  ReferencePlanarGraph(const PoseGraph<SE2>& graph, const std::vector<SE2>& T_w_kf);

  ceres::Problem& problem() { return problem_; }
  SE2 T_w_kf(size_t i) const { return SE2(x_[i].z(), x_[i].head<2>()); }

 private:
  std::vector<Eigen::Vector3d> x_;
  ceres::Problem problem_;
};

template <class Pose>
struct ReferenceGraphOf;
template <>
struct ReferenceGraphOf<SE3> {
  using Type = ReferenceSpaceGraph;
};
template <>
struct ReferenceGraphOf<SE2> {
  using Type = ReferencePlanarGraph;
};
template <class Pose>
using ReferenceGraph = typename ReferenceGraphOf<Pose>::Type;

}  // namespace plslam::test
