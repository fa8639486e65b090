// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>

#include <cmath>

#include "core/geometry/se3.h"
#include "core/geometry/stereo_camera.h"

namespace plslam {

/// A residual vector linearised at a pose: r, its derivative by the right perturbation x of T_ref_cur * Exp(x), and
/// the covariance S of r (measurement noise, and landmark covariance propagated by the projection). Rows without a
/// measurement have a zero residual, a zero derivative and unit variance, and do not count in `dimension`.
template <int N>
struct Residual {
  Eigen::Matrix<double, N, 1> r;
  Eigen::Matrix<double, N, 6, Eigen::RowMajor> J;
  Eigen::Matrix<double, N, N> S;
  int dimension = 0;
};

/// Pose and camera common to all residuals of one pose.
struct PoseView {
  PoseView(const SE3& T_cur_ref, const StereoCamera& camera_in)
      : R(T_cur_ref.R()), t(T_cur_ref.translation()), camera(camera_in), min_depth_m(camera_in.MinDepth()) {}

  Eigen::Matrix3d R;
  Eigen::Vector3d t;
  const StereoCamera& camera;
  double min_depth_m;
};

/// Returns the derivative of g^T p_c by the perturbation: p_c moves by -translation - rotation x p_c.
inline Eigen::Matrix<double, 1, 6> PoseRow(const Eigen::Vector3d& g, const Eigen::Vector3d& p_c) {
  Eigen::Matrix<double, 1, 6> row;
  row << -g.transpose(), g.cross(p_c).transpose();
  return row;
}

/// Computes the lower Cholesky factor L of S in place, and applies L^-1 to r and J: afterwards r ~ N(0, I). Returns
/// false if S is not positive definite or not finite.
template <int N>
bool Whiten(Residual<N>& residual) {
  auto& S = residual.S;
  for (int j = 0; j < N; ++j) {
    double pivot = S(j, j);
    for (int k = 0; k < j; ++k) pivot -= S(j, k) * S(j, k);
    if (!(pivot > 0.0) || !std::isfinite(pivot)) return false;
    const double diagonal = std::sqrt(pivot);
    const double inverse = 1.0 / diagonal;
    S(j, j) = diagonal;
    for (int i = j + 1; i < N; ++i) {
      double value = S(i, j);
      for (int k = 0; k < j; ++k) value -= S(i, k) * S(j, k);
      S(i, j) = value * inverse;
    }
    for (int k = 0; k < j; ++k) {
      residual.r(j) -= S(j, k) * residual.r(k);
      residual.J.row(j) -= S(j, k) * residual.J.row(k);
    }
    residual.r(j) *= inverse;
    residual.J.row(j) *= inverse;
  }
  return residual.r.allFinite() && residual.J.allFinite();
}

/// Returns false for a covariance that is not finite or has a negative variance, and for a position so uncertain (a
/// hundred times its distance) that linearisation is meaningless.
inline bool IsUsableCovariance(const Eigen::Matrix3d& covariance, const Eigen::Vector3d& position) {
  constexpr double kUncertain = 1e4;
  return covariance.allFinite() && covariance.diagonal().minCoeff() >= 0.0 &&
         covariance.trace() <= kUncertain * position.squaredNorm();
}

}  // namespace plslam
