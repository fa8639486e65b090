// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "tools/evaluate/alignment.h"

namespace plslam {

/// Absolute trajectory error of each pair (Sturm et al. 2012): distance of the positions after alignment, and the
/// angle between the orientations after the same alignment.
struct AbsoluteErrors {
  std::vector<double> translation_m;
  std::vector<double> rotation_rad;
};

AbsoluteErrors ComputeAbsoluteErrors(const PosePairs& pairs, const Similarity& alignment);

/// Angle of the rotation between two orientations, in [0, pi].
double AngleBetween(const Eigen::Quaterniond& a, const Eigen::Quaterniond& b);

}  // namespace plslam
