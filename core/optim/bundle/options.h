// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>

#include "core/config/choices.h"
#include "core/config/fields.h"

namespace plslam {

/// Parameters of a line: four (its endpoints move across it only), or two endpoints, as in the paper.
enum class LineParameters { kMinimal, kEndpoints };
constexpr auto ChoicesOf(LineParameters) {
  return std::array{Choice{"minimal", LineParameters::kMinimal}, Choice{"endpoints", LineParameters::kEndpoints}};
}

/// Bundle adjustment (PL-SLAM §V.B).
struct BundleOptions {
  LineParameters lines = LineParameters::kMinimal;
  /// Levenberg-Marquardt iterations of each pass.
  int max_iterations = 6;
  /// Passes after the first, each without the outliers found.
  int max_refinements = 1;
  /// Residual at which the loss becomes linear, in standard deviations.
  double huber_delta = 1.5;
  /// Chi-square gate of inliers, as quantile of the normal distribution (2.33 keeps 99 %).
  double gate_sigmas = 2.33;
  /// Share of the loss that a step must gain for another one to follow.
  double function_tolerance = 3e-2;
  /// Number of free poses above which their system is sparse; below, a dense one is faster, which takes 0.6 kB for each
  /// pair of them.
  int max_dense_poses = 150;
};

template <class Visitor>
void VisitFields(Visitor& visit, BundleOptions& o) {
  visit("lines", o.lines,
        "parameters of a line: minimal (four: endpoints move across the line only) or its two endpoints, as in the "
        "paper");
}

}  // namespace plslam
