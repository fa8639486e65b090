// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "core/optim/bundle/bundle.h"
#include "core/optim/reference/pose_parameters.h"
#include "core/optim/reference/stereo_pair.h"

namespace plslam::reference {

/// Reprojection of a point, whitened: measured minus predicted (u, v, disparity), each divided by its standard
/// deviation; (u, v) without disparity. An RGB-D camera measures the virtual disparity d = f b / Z. Parameters: the
/// pose (`PoseAt`) and the position of the point in the map. Returns false for a point behind the camera.
struct PointFunctor {
  PointObservation observation;
  SE3 start;
  StereoCamera camera;

  int rows() const { return observation.uvd.z() >= 0.0 ? 3 : 2; }

  template <typename T>
  bool operator()(const T* pose, const T* p_w, T* residuals) const {
    const Vector3<T> p_c = PoseAt<T>(start, pose).ToCamera(Eigen::Map<const Vector3<T>>(p_w));
    if (!(p_c.z() > camera.MinDepth())) return false;
    const T u = camera.f_px * p_c.x() / p_c.z() + camera.cx_px;
    const T v = camera.f_px * p_c.y() / p_c.z() + camera.cy_px;
    residuals[0] = (observation.uvd.x() - u) / observation.sigma_px;
    residuals[1] = (observation.uvd.y() - v) / observation.sigma_px;
    if (rows() == 3) {
      const T disparity = camera.f_px * camera.baseline_m / p_c.z();
      residuals[2] = (observation.uvd.z() - disparity) / observation.sigma_disparity_px;
    }
    return true;
  }
};

/// The same of a pair that need not be ideal: with a block of `kPairSize` parameters, and a fourth row for the measured
/// difference of the rows (right minus left), where there is one.
struct PairPointFunctor {
  PointFunctor ideal;
  Vector6d twist = Vector6d::Zero();
  double row_offset_px = 0.0;
  double sigma_row_px = -1.0;

  int rows() const { return ideal.rows() < 3 ? 2 : (sigma_row_px > 0.0 ? 4 : 3); }

  template <typename T>
  bool operator()(const T* pose, const T* p_w, const T* pair, T* residuals) const {
    const PointObservation& seen = ideal.observation;
    const Vector3<T> p_c = PoseAt<T>(ideal.start, pose).ToCamera(Eigen::Map<const Vector3<T>>(p_w));
    if (!(p_c.z() > ideal.camera.MinDepth())) return false;
    const PairPixels<T> pixels(ideal.camera, pair, twist, p_c);
    if (!pixels.in_front) return false;
    residuals[0] = (seen.uvd.x() - pixels.left.x()) / seen.sigma_px;
    residuals[1] = (seen.uvd.y() - pixels.left.y()) / seen.sigma_px;
    if (rows() >= 3) residuals[2] = (seen.uvd.z() - pixels.left.x() + pixels.right.x()) / seen.sigma_disparity_px;
    if (rows() == 4) residuals[3] = (row_offset_px - pixels.right.y() + pixels.left.y()) / sigma_row_px;
    return true;
  }
};

}  // namespace plslam::reference
