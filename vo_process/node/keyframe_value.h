#pragma once

#include "core/map/keyframe.h"
#include "vo_process/tracking/odometry.h"

namespace plslam {

/// What others get of a frame that became a keyframe (`result.keyframe` must be set); session, time and frame are the
/// caller's.
Keyframe ToKeyframe(const OdometryResult& result);

}  // namespace plslam
