#pragma once

#include <vector>

#include "plslam/pose_t.hpp"
#include "plslam/tracks_t.hpp"
#include "vo_process/stereo/stage_timer.h"
#include "vo_process/tracking/odometry.h"

namespace plslam {

// What odometry says, as messages; headers and frame ids are the caller's.

pose_t ToPoseMessage(const OdometryResult& result, const SE3& T_w_odom, const std::vector<StageTime>& stages);

tracks_t ToTracksMessage(const OdometryResult& result);

}  // namespace plslam
