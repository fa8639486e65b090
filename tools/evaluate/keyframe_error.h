// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include "core/accuracy/association.h"

namespace plslam {

/// Errors of the motion between consecutive keyframes, the measure of PL-SLAM's tables (§VII: "relative errors
/// between the KFs positions"). The paper prints no formula; docs/metrics.md says how it is read here.
struct KeyframeErrors {
  int motions = 0;
  double rmse_m = 0.0;              ///< translation error of a motion
  double rmse_deg = 0.0;            ///< rotation error of a motion
  int moving = 0;                   ///< motions of at least 1 cm; the relative figures are over these
  double relative_rmse = 0.0;       ///< of translation error / true distance
  double t_rel_percent = 0.0;       ///< mean of the same
  double R_rel_deg_per_100m = 0.0;  ///< mean of rotation error / true distance
};

/// `keyframe_t_ns` are the times of the keyframes in the estimated trajectory, increasing. Keyframes without an
/// associated true pose are passed over.
KeyframeErrors ComputeKeyframeErrors(const PosePairs& pairs, const std::vector<int64_t>& keyframe_t_ns);

}  // namespace plslam
