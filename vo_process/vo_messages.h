#pragma once

#include <vector>

#include "plslam/pose_t.hpp"
#include "plslam/tracks_t.hpp"
#include "vo_process/odometry.h"
#include "vo_process/stage_timer.h"

namespace plslam {

// What odometry says, as messages; headers and frame ids are the caller's.

pose_t ToPoseMessage(const OdometryResult& result, const SE3& T_w_odom, const std::vector<StageTime>& stages);

tracks_t ToTracksMessage(const OdometryResult& result);

}  // namespace plslam
