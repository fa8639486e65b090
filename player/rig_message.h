#pragma once

#include "core/geometry/calibration.h"
#include "plslam/camera_t.hpp"
#include "plslam/pose3_t.hpp"

namespace plslam {

/// A pose as it goes over the wire: the quaternion with w >= 0.
pose3_t ToMessage(const SE3& T);

/// A rig as it goes over the wire, the header left empty.
camera_t ToMessage(const RigCalibration& rig);

}  // namespace plslam
