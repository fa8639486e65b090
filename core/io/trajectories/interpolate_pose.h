// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>

#include "core/io/trajectories/trajectory.h"

namespace plslam {

/// The largest gap of a ground truth that datasets interpolate over.
inline constexpr int64_t kMaxTruthGap_ns = 150'000'000;
/// Times so near are one moment: files round them, to milliseconds at worst.
inline constexpr int64_t kSameMoment_ns = 1'000'000;

/// Pose at a time between two poses of a trajectory: translation on the straight line, rotation on the great arc.
/// Before the first and after the last pose, and where the two are further apart than `max_gap_ns`, it is that of the
/// same moment, and nullopt where there is none: nothing is extrapolated. Exactly the pose itself where the times
/// agree.
std::optional<SE3> InterpolatePose(const Trajectory& trajectory, int64_t t_ns, int64_t max_gap_ns);

}  // namespace plslam
