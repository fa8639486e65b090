#pragma once

#include "core/config/fields.h"

namespace plslam {

/// Robust motion estimation (PL-SLAM §IV.C).
struct MotionOptions {
  int max_iterations = 10;
  double huber_delta = 1.0;
  double min_scale_px = 1.0;
  int min_inliers = 8;
  double max_scale = 3.0;
  double gate_sigmas = 2.33;
  int max_refinements = 3;
  bool landmark_covariance = true;
  double max_relative_sigma = 0.5;
};

template <class Visitor>
void VisitFields(Visitor& visit, MotionOptions& o) {
  visit("max_iterations", o.max_iterations, Bounds{1, 100}, "Gauss-Newton iterations of each of the two steps");
  visit("huber_delta", o.huber_delta, Bounds{0.1, 100}, "where pseudo-Huber turns linear, in standard deviations");
  visit("min_scale_px", o.min_scale_px, Bounds{0.01, 100}, "floor of the robust scale of the residuals");
  visit("min_inliers", o.min_inliers, Bounds{3, 1000}, "inliers (points + 2 x lines) below which motion is unknown");
  visit("max_scale", o.max_scale, Bounds{1, 100}, "largest robust scale, in standard deviations");
  visit("gate_sigmas", o.gate_sigmas, Bounds{0.5, 10},
        "chi-square gate of inliers, as quantile of the normal distribution (2.33 keeps 99 %)");
  visit("max_refinements", o.max_refinements, Bounds{1, 20}, "rounds of the second step, each with new inliers");
  visit("landmark_covariance", o.landmark_covariance,
        "weigh by the uncertainty of the landmarks too; the paper weighs by that of the measurements alone");
  visit("max_relative_sigma", o.max_relative_sigma, Bounds{0.001, 1000},
        "deviation of the motion (per median depth, or in rad) above which it is unknown");
}

}  // namespace plslam
