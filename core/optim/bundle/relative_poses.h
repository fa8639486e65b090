// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "core/optim/bundle/bundle.h"
#include "core/optim/bundle/camera_view.h"
#include "core/optim/bundle/pose_system.h"

namespace plslam {

/// Whitened difference of two poses from what was measured between them: L^-1 Log(T_a_b^-1 T_w_a^-1 T_w_b), six rows,
/// where L L^T is the covariance.
class RelativePoseCost {
 public:
  /// The poses must outlive it. `IsUsable` says whether it may be added.
  RelativePoseCost(const RelativePose& measured, AdjustedPose& a, AdjustedPose& b);

  /// The covariance is positive definite, and one of the poses is free.
  bool IsUsable() const { return usable_; }

  /// Residuals at the poses as they are, and where not null their Jacobians (row-major, 6 x 6).
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

/// The relative poses of an adjustment that count: measured well, between poses that see something, of which one is
/// free.
class RelativePoses {
 public:
  /// Where their loss turns linear, in standard deviations.
  static constexpr double kDelta = 3.0;

  RelativePoses(const std::vector<RelativePose>& measured, std::vector<AdjustedPose>& poses);

  /// Adds information and gradient at the poses as they are. Returns the loss.
  double Linearise(PoseSystem& system) const;

  /// Twice the cost at the poses as they are.
  double Loss() const;

  /// Says of their poses that they are constant.
  void HoldPoses();

  const std::vector<RelativePoseCost>& costs() const { return costs_; }

 private:
  std::vector<RelativePoseCost> costs_;
};

}  // namespace plslam
