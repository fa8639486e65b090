// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <vector>

#include "core/geometry/se3.h"

namespace plslam::test {

/// Returns the root mean square of the position error of each complete lap, in m, after the first two laps were aligned
/// with the truth: a place that drifts has errors that grow with the laps.
std::vector<double> ErrorsOfLaps(const std::vector<SE3>& estimated, const std::vector<SE3>& truth, size_t lap);

/// Mean of the last `n` values.
double MeanOfLast(const std::vector<double>& values, size_t n);

}  // namespace plslam::test
