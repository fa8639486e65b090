// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "core/config/fields.h"

namespace plslam {

/// Robust motion estimation (PL-SLAM §IV.C).
struct MotionOptions {
  /// Residual at which pseudo-Huber becomes linear, in standard deviations.
  double huber_delta = 1.0;
  /// Floor of the robust scale of the residuals.
  double min_scale_px = 1.0;
  /// Inliers (points + 2 x lines) below which the motion is undetermined.
  int min_inliers = 8;
  /// Largest robust scale, in standard deviations.
  double max_scale = 3.0;
  /// Chi-square gate of inliers, as quantile of the normal distribution (2.33 keeps 99 %).
  double gate_sigmas = 2.33;
  /// Rounds of the second step, each with updated inliers.
  int max_refinements = 3;
  bool landmark_covariance = true;
  /// Sigma of the motion (relative to median depth, or in rad) above which it is undetermined.
  double max_relative_sigma = 0.5;
};

template <class Visitor>
void VisitFields(Visitor& visit, MotionOptions& o) {
  visit("landmark_covariance", o.landmark_covariance,
        "weight by the uncertainty of the landmarks too; the paper uses that of the measurements only");
}

}  // namespace plslam
