// SPDX-License-Identifier: BSD-3-Clause
#include "core/geometry/stereo_camera.h"

namespace plslam {

Eigen::Matrix3d StereoCamera::ProjectStereoJacobian(const Eigen::Vector3d& p_c) const {
  const double inverse_z = 1.0 / p_c.z();
  const double k = f_px * inverse_z;
  Eigen::Matrix3d J;
  J << k, 0.0, -k * p_c.x() * inverse_z,  //
      0.0, k, -k * p_c.y() * inverse_z,   //
      0.0, 0.0, -k * baseline_m * inverse_z;
  return J;
}

Eigen::Matrix3d StereoCamera::BackprojectCovariance(const Eigen::Vector3d& uvd, double sigma_px,
                                                    double sigma_disparity_px) const {
  const double z = Depth(uvd.z());
  const double z_by_d = -z / uvd.z();
  const double x = (uvd.x() - cx_px) / f_px;
  const double y = (uvd.y() - cy_px) / f_px;
  Eigen::Matrix3d J;
  J << z / f_px, 0.0, x * z_by_d,  //
      0.0, z / f_px, y * z_by_d,   //
      0.0, 0.0, z_by_d;
  const double variance = sigma_px * sigma_px;
  const Eigen::Vector3d variances(variance, variance, sigma_disparity_px * sigma_disparity_px);
  return J * variances.asDiagonal() * J.transpose();
}

}  // namespace plslam
