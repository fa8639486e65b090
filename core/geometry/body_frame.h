// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "core/geometry/calibration.h"
#include "core/geometry/se3.h"

namespace plslam {

/// Returns the pose of the rectified left camera in the body frame, from the rig's `T_b_cam`. An identity means that
/// the mounting is unknown: the camera then looks along the body's x axis with its image upright. Throws as `Rectify`.
SE3 BodyFromCamera(const RigCalibration& rig);

}  // namespace plslam
