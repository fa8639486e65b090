// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>
#include <Eigen/Core>

#include "core/optim/reference/line_functor.h"

namespace plslam::reference {

/// Line as in the paper (PL-SLAM §V.B, `LineEndpointCost`): distances of the two projected endpoints from the infinite
/// observed lines, of the left and then of the right image. The observed line has the errors of its two observed ends,
/// so the distances are correlated, and larger for endpoints beyond these: the residuals are L^-1 d, with L L^T the
/// covariance of the distances d where the functor is made. Parameters: pose, and both endpoints in the map.
struct LineEndpointFunctor {
  LineEndpointFunctor(const LineObservation& seen_in, const Segment3& segment_w, const SE3& T_w_c,
                      const StereoCamera& camera_in)
      : images(seen_in), start(T_w_c), camera(camera_in) {
    const Eigen::Vector2d along = (seen_in.observed.q - seen_in.observed.p).normalized();
    const Segment3 segment_c{T_w_c.Inverse() * segment_w.p, T_w_c.Inverse() * segment_w.q};
    // Derivative of d by the errors of the observed ends p and q across the line and of their disparities.
    Eigen::Matrix4d by_error = Eigen::Matrix4d::Zero();
    for (int i = 0; i < 2; ++i) {
      const Eigen::Vector3d& end_c = i == 0 ? segment_c.p : segment_c.q;
      double t = i;
      if (end_c.z() > camera.MinDepth()) {
        t = along.dot(camera.Project(end_c) - seen_in.observed.p) / seen_in.observed.Length();
        t = std::clamp(t, -100.0, 101.0);
      }
      by_error.row(i) << 1.0 - t, t, 0.0, 0.0;
      if (!images.has_right) continue;
      const double shared = images.left.normal.dot(images.right.normal);
      const double tilt = images.right.normal.x();
      by_error.row(i + 2) << shared * (1.0 - t), shared * t, tilt * (1.0 - t), tilt * t;
    }
    const Eigen::Vector4d sigmas(seen_in.sigma_px, seen_in.sigma_px, seen_in.sigma_disparity_p_px,
                                 seen_in.sigma_disparity_q_px);
    const Eigen::Matrix4d scaled = by_error * sigmas.asDiagonal();
    const double of_its_own = 0.1 * seen_in.sigma_px;
    const Eigen::Matrix4d covariance =
        scaled * scaled.transpose() + of_its_own * of_its_own * Eigen::Matrix4d::Identity();
    L_inverse = covariance.llt().matrixL().solve(Eigen::Matrix4d::Identity());
  }

  int rows() const { return images.has_right ? 4 : 2; }

  template <typename T>
  bool operator()(const T* pose, const T* endpoints_w, T* residuals) const {
    const PoseAt<T> T_w_c(start, pose);
    Eigen::Matrix<T, 4, 1> d = Eigen::Matrix<T, 4, 1>::Zero();
    for (int i = 0; i < 2; ++i) {
      const Vector3<T> p_c = T_w_c.ToCamera(Eigen::Map<const Vector3<T>>(endpoints_w + 3 * i));
      if (!(p_c.z() > camera.MinDepth())) return false;
      const T v = camera.f_px * p_c.y() / p_c.z() + camera.cy_px;
      const T u = camera.f_px * p_c.x() / p_c.z() + camera.cx_px;
      const T u_right = camera.f_px * (p_c.x() - camera.baseline_m) / p_c.z() + camera.cx_px;
      d(i) = images.left.Distance(Eigen::Matrix<T, 2, 1>(u, v));
      if (images.has_right) d(i + 2) = images.right.Distance(Eigen::Matrix<T, 2, 1>(u_right, v));
    }
    for (int row = 0; row < rows(); ++row) residuals[row] = L_inverse.row(row).cast<T>() * d;
    return true;
  }

  StereoLineImages images;
  SE3 start;
  StereoCamera camera;
  Eigen::Matrix4d L_inverse;
};

}  // namespace plslam::reference
