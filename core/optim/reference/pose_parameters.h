// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>

#include <ceres/rotation.h>
#include <Eigen/Core>

#include "core/geometry/se3.h"

namespace plslam::reference {

template <typename T>
using Vector3 = Eigen::Matrix<T, 3, 1>;
template <typename T>
using Matrix3 = Eigen::Matrix<T, 3, 3>;

/// Camera pose of six parameters [a; w] relative to a start pose: R_w_c = R_start Exp(w), t_w_c = t_start + a. The same
/// vector space as `AdjustedPose`, so that Jacobians by it can be compared number by number.
template <typename T>
struct PoseAt {
  PoseAt(const SE3& start, const T* x) : t_w_c(start.translation().cast<T>() + Eigen::Map<const Vector3<T>>(x)) {
    Matrix3<T> turn;
    ceres::AngleAxisToRotationMatrix(x + 3, turn.data());
    R_w_c = start.R().cast<T>() * turn;
  }

  Vector3<T> ToCamera(const Vector3<T>& p_w) const { return R_w_c.transpose() * (p_w - t_w_c); }

  Matrix3<T> R_w_c;
  Vector3<T> t_w_c;
};

/// The pose after a step of its parameters.
inline SE3 MovedPose(const SE3& start, const double* x) {
  return SE3(start.rotation() * ExpSO3(Eigen::Map<const Eigen::Vector3d>(x + 3)),
             start.translation() + Eigen::Map<const Eigen::Vector3d>(x));
}

}  // namespace plslam::reference
