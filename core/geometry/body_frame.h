// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "core/geometry/calibration.h"
#include "core/geometry/se3.h"

namespace plslam {

/// Body from the rectified left camera: by the rig's `T_b_cam`; where that is the identity, so that nobody has said
/// how the camera is mounted, it looks along the body's x axis with its image upright. Throws what `Rectify` throws.
SE3 BodyFromCamera(const RigCalibration& rig);

}  // namespace plslam
