// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>

#include <ceres/rotation.h>
#include <Eigen/Core>

#include "core/geometry/stereo_camera.h"
#include "core/optim/reference/pose_parameters.h"

namespace plslam::reference {

/// Parameters by which a stereo pair differs from the ideal one of `StereoCamera`; all zero: it is ideal.
enum PairParameter : int {
  kFocal = 0,  ///< focal length of both cameras minus the given one [px]
  kCentreX,    ///< principal point of both minus the given one [px]
  kCentreY,    ///< [px]
  kRadial,  ///< radial distortion of both: pixels are farther from the principal point by 1 + kRadial r^2, r = tan(angle)
  kTurnX,       ///< rotation vector of the right camera [rad]: about x it shifts rows,
  kTurnY,       ///< about y it shifts disparities,
  kTurnZ,       ///< about z both, in proportion to the pixel
  kDirectionY,  ///< direction of the baseline: y and z of the right camera's centre, in baselines
  kDirectionZ,  ///<
  kFocalRatio,  ///< focal length of the right camera over that of the left one, minus 1
  kTimeSkew,    ///< time at which the right image is taken after the left one [s]
  kPairSize
};

/// Both pixels of a point of the left camera frame. The length of the baseline is the unit of all lengths, which images
/// alone do not determine: it has no parameter.
template <typename T>
struct PairPixels {
  /// `twist` is the velocity of the camera in its own frame, [m/s; rad/s], for the time skew.
  PairPixels(const StereoCamera& camera, const T* pair, const Vector6d& twist, const Vector3<T>& p_c) {
    const T f = camera.f_px + pair[kFocal];
    const T cx = camera.cx_px + pair[kCentreX];
    const T cy = camera.cy_px + pair[kCentreY];
    const auto project = [&](const Vector3<T>& p, const T& focal) {
      const Eigen::Matrix<T, 2, 1> x(p.x() / p.z(), p.y() / p.z());
      const T scale = focal * (1.0 + pair[kRadial] * x.squaredNorm());
      return Eigen::Matrix<T, 2, 1>(scale * x.x() + cx, scale * x.y() + cy);
    };
    left = project(p_c, f);
    const Vector3<T> v = twist.head<3>().cast<T>();
    const Vector3<T> w = twist.tail<3>().cast<T>();
    const Vector3<T> later = p_c - pair[kTimeSkew] * (v + w.cross(p_c));
    const Vector3<T> centre(T(camera.baseline_m), camera.baseline_m * pair[kDirectionY],
                            camera.baseline_m * pair[kDirectionZ]);
    const Vector3<T> from_right = later - centre;
    Vector3<T> p_r;
    ceres::AngleAxisRotatePoint(pair + kTurnX, from_right.data(), p_r.data());
    right = project(p_r, f * (1.0 + pair[kFocalRatio]));
    in_front = p_c.z() > camera.MinDepth() && p_r.z() > camera.MinDepth();
  }

  Eigen::Matrix<T, 2, 1> left;
  Eigen::Matrix<T, 2, 1> right;
  bool in_front;
};

}  // namespace plslam::reference
