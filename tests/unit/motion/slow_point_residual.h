// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "core/motion/point_residual.h"
#include "core/motion/residual.h"

namespace plslam::test {

/// One point, row by row, in the form of the mathematics: the reference for `PointBatch`. Residual measured minus
/// predicted (u, v, disparity), in pixels. Returns false if the point is behind the camera or too near.
inline bool Linearize(const PreparedPoint& point, const PoseView& view, double sigma_floor_px,
                      Residual<3>& residual) {
  const Eigen::Vector3d p_c = view.R * point.p_ref + view.t;
  if (!(p_c.z() > view.min_depth_m)) return false;
  const Eigen::Matrix3d J_p = view.camera.ProjectStereoJacobian(p_c);
  const Eigen::Matrix3d J_ref = J_p * view.R;
  residual.r = point.uvd - view.camera.ProjectStereo(p_c);
  // The measurement does not depend on the pose, the prediction is subtracted: hence the sign.
  for (int i = 0; i < 3; ++i) residual.J.row(i) = -PoseRow(J_p.row(i), p_c);
  residual.S.noalias() = J_ref * point.covariance * J_ref.transpose();
  const double sigma = std::max(point.sigma_px, sigma_floor_px);
  residual.S(0, 0) += sigma * sigma;
  residual.S(1, 1) += sigma * sigma;
  residual.dimension = 3;
  if (point.has_disparity) {
    const double sigma_d = std::max(point.sigma_disparity_px, sigma_floor_px);
    residual.S(2, 2) += sigma_d * sigma_d;
    return true;
  }
  residual.dimension = 2;
  residual.r(2) = 0.0;
  residual.J.row(2).setZero();
  residual.S.row(2) = Eigen::RowVector3d::UnitZ();
  residual.S.col(2) = Eigen::Vector3d::UnitZ();
  return true;
}

}  // namespace plslam::test
