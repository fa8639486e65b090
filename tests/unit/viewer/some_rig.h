// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "core/geometry/calibration.h"

namespace plslam::viewer {

/// Two pinhole cameras of 320 x 240 pixels side by side.
inline RigCalibration SomeRig() {
  RigCalibration rig;
  rig.name = "test";
  rig.left.width_px = rig.right.width_px = 320;
  rig.left.height_px = rig.right.height_px = 240;
  rig.left.fx_px = rig.left.fy_px = rig.right.fx_px = rig.right.fy_px = 200.0;
  rig.left.cx_px = rig.right.cx_px = 160.0;
  rig.left.cy_px = rig.right.cy_px = 120.0;
  rig.right.T_b_cam = SE3(Eigen::Quaterniond::Identity(), Eigen::Vector3d(0.1, 0, 0));
  rig.baseline_m = 0.1;
  return rig;
}

}  // namespace plslam::viewer
