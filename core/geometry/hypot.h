// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cmath>

namespace plslam {

/// Returns sqrt(x^2 + y^2), equal to the last bit on all processors. std::hypot is not: the C library computes it
/// differently if compiled with fused multiply-add (arm64). The first result is corrected by its residual as in C.
/// Borges, "An Improved Algorithm for hypot(a, b)", 2019 (arXiv 1904.09481), which gives the bits of the C library of
/// amd64. The squares of the arguments must neither overflow nor underflow.
inline double Hypot(double x, double y) {
  const double longer = std::max(std::abs(x), std::abs(y));
  const double shorter = std::min(std::abs(x), std::abs(y));
  const double length = std::sqrt(longer * longer + shorter * shorter);
  if (!(length > 0.0 && std::isfinite(length))) return length;
  // length^2 - longer^2 - shorter^2, in a form that loses little precision.
  double residual = 0.0;
  if (length <= 2.0 * shorter) {
    const double rest = length - shorter;
    residual = longer * (2.0 * rest - longer) + (rest - 2.0 * (longer - shorter)) * rest;
  } else {
    const double rest = length - longer;
    residual = 2.0 * rest * (longer - 2.0 * shorter) + ((4.0 * rest - shorter) * shorter + rest * rest);
  }
  return length - residual / (2.0 * length);
}

}  // namespace plslam
