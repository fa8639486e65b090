// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <map>

#include "core/geometry/se3.h"
#include "core/io/trajectories/trajectory.h"

namespace plslam::refine {

/// Displacement of the map frame by which a keyframe moved: T_w_kf(new) = T_new_old T_w_kf(old).
using Displacements = std::map<int64_t, SE3>;

/// Moves the frames of a trajectory with their keyframes (`by_time`: displacements by the time of the keyframe): a
/// keyframe by its own displacement, a frame between two keyframes by both, in proportion to its time, and frames
/// before the first and after the last one with the nearest. Independent of the frame whose poses the trajectory has,
/// as long as they are poses in the map.
Trajectory FollowKeyframes(const Trajectory& frames, const Displacements& by_time);

}  // namespace plslam::refine
