// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include "core/geometry/se3.h"

namespace plslam {

/// What counts as the same place. Between a revisit and another place lie pairs whose views overlap in part: neither
/// right nor wrong.
struct RevisitOptions {
  /// A revisit is at most this far away, in position and in direction of view.
  double distance_m = 1.0;
  double angle_deg = 30.0;
  /// Another place is farther away than one of these.
  double far_distance_m = 5.0;
  double far_angle_deg = 90.0;
  /// Pairs that follow each other sooner are no revisit and not looked at.
  double min_gap_s = 5.0;
};

enum class PairTruth { kIgnored, kRevisit, kOtherPlace };

/// A true pose of the camera.
struct TimedPose {
  int64_t t_ns = 0;
  SE3 T_w_c;
};

PairTruth ClassifyPair(const TimedPose& a, const TimedPose& b, const RevisitOptions& options);

}  // namespace plslam
