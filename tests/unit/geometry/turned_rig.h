// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <utility>

#include "core/geometry/calibration.h"

namespace plslam::test {

/// Returns the camera whose images are those of `camera` after cv::ROTATE_90_CLOCKWISE, at the same position.
inline CameraCalibration TurnedClockwise(const CameraCalibration& camera) {
  CameraCalibration turned = camera;
  std::swap(turned.width_px, turned.height_px);
  std::swap(turned.fx_px, turned.fy_px);
  turned.cx_px = camera.height_px - 1.0 - camera.cy_px;
  turned.cy_px = camera.cx_px;
  if (camera.model == "radtan" || camera.model == "rational") {
    turned.distortion[2] = camera.distortion[3];  // p1
    turned.distortion[3] = -camera.distortion[2];
  }
  Eigen::Matrix3d R_turned_camera;
  R_turned_camera << 0, -1, 0, 1, 0, 0, 0, 0, 1;
  turned.T_b_cam = camera.T_b_cam * SE3(Eigen::Matrix3d(R_turned_camera.transpose()), Eigen::Vector3d::Zero());
  return turned;
}

/// The rig with both cameras turned so many quarters clockwise: a pair side by side becomes one with the right camera
/// below (one quarter) or above (three quarters) the left one.
inline RigCalibration TurnedClockwise(RigCalibration rig, int quarters) {
  for (int i = 0; i < quarters; ++i) {
    rig.left = TurnedClockwise(rig.left);
    rig.right = TurnedClockwise(rig.right);
  }
  return rig;
}

}  // namespace plslam::test
