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

// What odometry says, as messages; headers and frame ids are the caller's.

pose_t ToPoseMessage(const OdometryResult& result, const SE3& T_w_odom, const std::vector<StageTime>& stages);

/// Of more features than the message has room for, new ones are left out first, points before lines.
tracks_t ToTracksMessage(const OdometryResult& result, int64_t max_bytes);

bodies_t ToBodiesMessage(const std::vector<BodyPose>& bodies);

/// What others get of a frame that became a keyframe (`result.keyframe` must be set); session, time and frame are the
/// caller's.
Keyframe ToKeyframe(const OdometryResult& result, const StereoCamera& camera);

/// A frame whose place in the map was asked for.
struct RelocalisationQuestion {
  Keyframe sent;
  SE3 T_odom_c;
  double asked_s = 0.0;
};

}  // namespace plslam::vo
