// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include "core/geometry/se3.h"
#include "core/map/keyframe.h"
#include "plslam/bodies_t.hpp"
#include "plslam/pose_t.hpp"
#include "plslam/tracks_t.hpp"
#include "vo_process/stereo/stage_timer.h"
#include "vo_process/tracking/odometry.h"

namespace plslam::vo {

// Conversion of odometry results to messages; the caller sets headers and frame ids.

pose_t ToPoseMessage(const OdometryResult& result, const SE3& T_w_odom, bool anchored,
                     const std::vector<StageTime>& stages);

/// If the tracks exceed `max_bytes`, omits new ones first, points before lines.
tracks_t ToTracksMessage(const OdometryResult& result, int64_t max_bytes);

bodies_t ToBodiesMessage(const std::vector<BodyPose>& bodies);

/// Returns the keyframe of a frame that became one (`result.keyframe` must be set); the caller sets session, time and
/// frame.
Keyframe ToKeyframe(const OdometryResult& result, const StereoCamera& camera);

/// Inlier score (points + 2 x lines) of the tracked landmarks of the map.
int64_t TrackedOfMap(const OdometryResult& result);

}  // namespace plslam::vo
