#pragma once

#include <string>

#include "core/config/fields.h"

namespace plslam {

/// Bundle adjustment (PL-SLAM §V.B).
struct BundleOptions {
  std::string lines = "minimal";
  int max_iterations = 6;
  int max_refinements = 1;
  double huber_delta = 1.5;
  double gate_sigmas = 2.33;
  double function_tolerance = 3e-2;
  int max_dense_poses = 150;
};

template <class Visitor>
void VisitFields(Visitor& visit, BundleOptions& o) {
  visit("lines", o.lines, OneOf{"minimal", "endpoints"},
        "parameters of a line: minimal (four: endpoints move across the line only) or its two endpoints, as in the "
        "paper");
  visit("max_iterations", o.max_iterations, Bounds{1, 1000}, "Levenberg-Marquardt iterations of each pass");
  visit("max_refinements", o.max_refinements, Bounds{0, 20},
        "passes after the first, each without the outliers found");
  visit("huber_delta", o.huber_delta, Bounds{0.1, 100}, "where the loss turns linear, in standard deviations");
  visit("gate_sigmas", o.gate_sigmas, Bounds{0.5, 10},
        "chi-square gate of inliers, as quantile of the normal distribution (2.33 keeps 99 %)");
  visit("function_tolerance", o.function_tolerance, Bounds{0, 1},
        "share of the cost that a step must gain for another one to follow");
  visit(
      "max_dense_poses", o.max_dense_poses, Bounds{0, 1000},
      "free poses above which Ceres solves the sparse system of all poses; below, a dense one is faster, which takes "
      "0.6 kB for each pair of them");
}

}  // namespace plslam
