// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "core/geometry/se3.h"

namespace plslam {

/// Returns how well positions determine the rotation about the line that fits the true ones best: the angle of an arc of
/// `ate_m` at their rms distance from this line. 90 degrees if they lie on it.
double RollSigma_rad(const std::vector<SE3>& truth, double ate_m);

/// "positions determine it to 2.1 deg about the path", or that they do not.
std::string RollText(double sigma_deg);

}  // namespace plslam
