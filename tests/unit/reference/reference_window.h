// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <vector>

#include <ceres/ceres.h>

#include "core/optim/bundle/bundle.h"
#include "core/optim/bundle/relative_poses.h"

namespace plslam::test {

/// A window as a Ceres problem: the same cost with line weights and anchors of the start, and with the weak priors of
/// landmarks that their observations do not determine there.
class ReferenceWindow {
 public:
  ReferenceWindow(const BundleProblem& given, bool endpoints, double huber_delta);

  /// To the end: tolerances are those of double precision.
  double Solve();
  ceres::Solver::Summary Solve(ceres::Solver::Options options);

  SE3 T_w_c(size_t i) const;

  /// The cost at the result of our solver.
  double CostAt(const BundleResult& result, bool endpoints);

 private:
  /// Information of the observations of a landmark at the start, and its least depth.
  template <int kSize>
  struct Knowledge {
    Eigen::Matrix<double, kSize, kSize> information = Eigen::Matrix<double, kSize, kSize>::Zero();
    double nearest_m = 1e9;
  };

  /// Landmarks are eliminated first.
  std::shared_ptr<ceres::ParameterBlockOrdering> Ordering();
  double* Pose(int i) { return poses_[static_cast<size_t>(i)].data(); }
  const SE3& Start(int i) const { return given_.poses[static_cast<size_t>(i)].T_w_c; }

  template <class Functor, int kSize>
  ceres::CostFunction* Add(const Functor& functor, int pose, double* landmark);
  template <class Functor, int kSize>
  void Add(const Functor& functor, int pose, double* landmark, const Eigen::Vector3d& middle_w,
           Knowledge<kSize>& knowledge);
  // As `ObservationGroup::HoldUndetermined`.
  template <int kSize>
  void AddPrior(double* landmark, const Knowledge<kSize>& known);
  void AddPoints();
  void AddLines();
  // With the prior along the line that endpoints always have (`AdjustedEndpoints::PriorWeight`).
  void AddEndpoints();
  void AddMotions();

  const BundleProblem& given_;
  ceres::SoftLOneLoss loss_;
  ceres::SoftLOneLoss motion_loss_{RelativePoses::kDelta};
  std::unique_ptr<ceres::Problem> problem_;
  std::vector<Vector6d> poses_;
  std::vector<Eigen::Vector3d> points_;
  std::vector<Vector6d> lines_;
};

}  // namespace plslam::test
