// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "core/optim/bundle/bundle.h"
#include "core/optim/bundle/camera_view.h"
#include "core/optim/bundle/pose_system.h"

namespace plslam {

/// Whitened error of a measured motion between two poses: L^-1 Log(T_a_b^-1 T_w_a^-1 T_w_b), six rows, with L L^T the
/// covariance.
class RelativePoseCost {
 public:
  /// The poses must outlive it. Add it only if `IsUsable`.
  RelativePoseCost(const RelativePose& measured, AdjustedPose& a, AdjustedPose& b);

  /// Whether the covariance is positive definite and one of the poses is free.
  bool IsUsable() const { return usable_; }

  /// Computes residuals at the current poses and, for non-null pointers, their Jacobians (row-major, 6 x 6).
  void Evaluate(double* residuals, double* by_a, double* by_b) const;

  AdjustedPose& a() const { return *a_; }
  AdjustedPose& b() const { return *b_; }

 private:
  SE3 T_b_a_measured_;
  Matrix6d whitening_ = Matrix6d::Identity();
  AdjustedPose* a_;
  AdjustedPose* b_;
  bool usable_ = false;
};

/// The relative poses of an adjustment that are used: with a valid covariance, between poses with observations, one of
/// them free.
class RelativePoses {
 public:
  /// Residual at which their loss becomes linear, in standard deviations.
  static constexpr double kDelta = 3.0;

  RelativePoses(const std::vector<RelativePose>& measured, std::vector<AdjustedPose>& poses);

  /// Adds information and gradient at the current poses. Returns the loss.
  double Linearise(PoseSystem& system) const;

  /// Twice the cost at the current poses.
  double Loss() const;

  /// Marks their poses as `constant`.
  void HoldPoses();

  const std::vector<RelativePoseCost>& costs() const { return costs_; }

 private:
  std::vector<RelativePoseCost> costs_;
};

}  // namespace plslam
