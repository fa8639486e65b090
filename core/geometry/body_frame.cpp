// SPDX-License-Identifier: BSD-3-Clause
#include "core/geometry/body_frame.h"

#include "core/geometry/rectification.h"

namespace plslam {
namespace {

bool IsIdentity(const SE3& T) { return T.Log().norm() < 1e-9; }

/// Rotates x right, y down, z forward to x forward, y left, z up.
SE3 BodyFromOptical() {
  Eigen::Matrix3d R;
  R << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  return {R, Eigen::Vector3d::Zero()};
}

}  // namespace

SE3 BodyFromCamera(const RigCalibration& rig) {
  const SE3 T_l_c(Rectify(rig).q_l_c, Eigen::Vector3d::Zero());
  return (IsIdentity(rig.left.T_b_cam) ? BodyFromOptical() : rig.left.T_b_cam) * T_l_c;
}

}  // namespace plslam
