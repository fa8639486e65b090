// SPDX-License-Identifier: BSD-3-Clause
#include "core/optim/bundle/bundle_covariance.h"

#include <algorithm>

namespace plslam {

double BundleCovariance::Excess() const {
  // Residuals are smaller by the degrees of freedom that the adjustment fits.
  const double free = rows_ - landmark_parameters_ - 6.0 * free_poses_;
  if (!(free > 0.0) || !(expected_squares_ > 0.0)) return 1.0;
  return std::max(1.0, weighted_squares_ / (expected_squares_ * free / rows_));
}

std::vector<Matrix6d> BundleCovariance::OfPoses(const std::vector<AdjustedPose>& poses) const {
  const std::vector<Matrix6d> of_free = reduced_.Covariances();
  const double excess = Excess();
  std::vector<Matrix6d> covariances(poses.size(), Matrix6d::Zero());
  for (size_t i = 0; i < poses.size(); ++i) {
    if (poses[i].column >= 0) covariances[i] = excess * poses[i].RightCovariance(of_free[poses[i].column]);
  }
  return covariances;
}

}  // namespace plslam
