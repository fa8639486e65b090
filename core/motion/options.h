#pragma once

#include "core/config/fields.h"

namespace plslam {

/// Robust motion estimation (PL-SLAM §IV.C).
struct MotionOptions {
  int max_iterations = 10;
  double huber_delta = 1.5;
  double min_scale_px = 1.0;
  int min_inliers = 8;
};

template <class Visitor>
void VisitFields(Visitor& visit, MotionOptions& o) {
  visit("max_iterations", o.max_iterations, Bounds{1, 100}, "Gauss-Newton iterations of each of the two steps");
  visit("huber_delta", o.huber_delta, Bounds{0.1, 100}, "where pseudo-Huber turns linear, in standard deviations");
  visit("min_scale_px", o.min_scale_px, Bounds{0.01, 100}, "floor of the robust scale of the residuals");
  visit("min_inliers", o.min_inliers, Bounds{3, 1000}, "inliers (points + 2 x lines) below which motion is unknown");
}

}  // namespace plslam
