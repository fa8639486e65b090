// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include "core/io/trajectories/trajectory.h"

namespace plslam {

/// An estimated pose and the true pose at (about) the same time.
struct PosePair {
  int64_t t_ns = 0;  ///< of the estimate
  SE3 estimate;
  SE3 truth;
  int estimate_index = 0;  ///< index in the estimated trajectory
};

using PosePairs = std::vector<PosePair>;

/// Returns the error (Q_i^-1 Q_j)^-1 (P_i^-1 P_j) of the motion from pair i to pair j, for truth Q and estimate P.
SE3 MotionError(const PosePair& i, const PosePair& j);

/// Pairs poses whose times differ by at most `max_difference_ns`, each used once, closest pairs first (Sturm et al.
/// 2012). The result is sorted by time. Times of both trajectories must increase.
PosePairs AssociateNearest(const Trajectory& estimate, const Trajectory& truth, int64_t max_difference_ns);

/// Pairs each estimated pose with the truth interpolated at its time (position linearly, rotation spherically), if the
/// true poses before and after it are at most `max_gap_ns` apart.
PosePairs AssociateInterpolated(const Trajectory& estimate, const Trajectory& truth, int64_t max_gap_ns);

}  // namespace plslam
