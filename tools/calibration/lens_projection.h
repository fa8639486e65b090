// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>

#include <cmath>
#include <string_view>

namespace plslam {

/// Pixel of a point (camera frame, z > 0) with the parameters fx fy cx cy and then the lens model's coefficients. The
/// same lenses as core/geometry/distortion.h, which has derivatives by the point only: this is a template, so that
/// Ceres differentiates by the parameters too. "radtan" (with k3) or "equidistant". Returns whether the model holds
/// there.
template <typename T>
bool ProjectLens(std::string_view model, const T* parameters, const T* p, T* pixel) {
  using std::atan2;
  using std::sqrt;
  if (!(p[2] > T(1e-6))) return false;
  const T* k = parameters + 4;
  T x = p[0] / p[2], y = p[1] / p[2];
  const T r2 = x * x + y * y;
  if (model == "radtan") {
    const T radial = 1.0 + r2 * (k[0] + r2 * (k[1] + r2 * k[4]));
    const T xd = x * radial + 2.0 * k[2] * x * y + k[3] * (r2 + 2.0 * x * x);
    y = y * radial + k[2] * (r2 + 2.0 * y * y) + 2.0 * k[3] * x * y;
    x = xd;
  } else if (r2 > T(1e-16)) {
    // Equidistant. The square root has no derivative at 0.
    const T r = sqrt(r2), angle = atan2(r, T(1.0)), a2 = angle * angle;
    const T scale = angle * (1.0 + a2 * (k[0] + a2 * (k[1] + a2 * (k[2] + a2 * k[3])))) / r;
    x = scale * x;
    y = scale * y;
  }
  pixel[0] = parameters[0] * x + parameters[2];
  pixel[1] = parameters[1] * y + parameters[3];
  return true;
}

}  // namespace plslam
