// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "core/accuracy/association.h"

namespace plslam {

/// Mean errors over the segments of one length.
struct KittiLengthError {
  double length_m = 0.0;
  int segments = 0;
  double t_rel_percent = 0.0;
  double r_rel_deg_per_100m = 0.0;
};

/// Mean over all segments of all lengths, and one row for each length that has a segment.
struct KittiErrors {
  int segments = 0;
  double t_rel_percent = 0.0;
  double r_rel_deg_per_100m = 0.0;
  std::vector<KittiLengthError> lengths;
};

/// The odometry metric of the KITTI development kit (Geiger et al. 2012; `calcSequenceErrors` of its
/// evaluate_odometry): from every `step`-th pose, for each length, to the first pose whose true path length exceeds
/// that of the start by the length; error = inverse(estimated motion) * true motion; translation and rotation angle
/// divided by the length; mean over all segments. Poses are the associated ones, in order.
KittiErrors ComputeKittiErrors(const PosePairs& pairs, const std::vector<double>& lengths_m, int step);

/// 100, 200, ..., 800 m from every tenth pose: the kit's own.
KittiErrors ComputeKittiErrors(const PosePairs& pairs);

/// The same for sequences too short for the kit: 10, 20, ..., 50 m from every pose. No figure of the benchmark.
KittiErrors ComputeShortKittiErrors(const PosePairs& pairs);

}  // namespace plslam
