#pragma once

#include <ceres/ceres.h>

#include "core/optim/bundle.h"
#include "core/optim/camera_view.h"

namespace plslam {

/// Whitened difference of two poses from what was measured between them: L^-1 Log(T_a_b^-1 T_w_a^-1 T_w_b), six rows,
/// where L L^T is the covariance. Parameters are the free ones of the two poses, a before b.
class RelativePoseCost : public ceres::CostFunction {
 public:
  /// The poses must outlive it. `IsUsable` says whether it may be added.
  RelativePoseCost(const RelativePose& measured, const AdjustedPose& a, const AdjustedPose& b);

  /// The covariance is positive definite, and one of the poses is free.
  bool IsUsable() const { return usable_; }

  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const override;

 private:
  SE3 T_b_a_measured_;
  Matrix6d whitening_ = Matrix6d::Identity();
  const AdjustedPose& a_;
  const AdjustedPose& b_;
  bool usable_ = false;
};

}  // namespace plslam
