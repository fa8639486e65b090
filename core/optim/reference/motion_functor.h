// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <ceres/rotation.h>
#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <Eigen/Geometry>

#include "core/optim/bundle/bundle.h"
#include "core/optim/reference/pose_parameters.h"

namespace plslam::reference {

template <typename T>
using Vector6 = Eigen::Matrix<T, 6, 1>;

/// Measured from estimated motion between two poses: E = T_a_b^-1 T_w_a^-1 T_w_b, as rotation and translation.
template <typename T>
struct MotionError {
  MotionError(const SE3& T_a_b, const PoseAt<T>& a, const PoseAt<T>& b) {
    const Matrix3<T> R_b_a = T_a_b.R().transpose().cast<T>();
    R = R_b_a * a.R_w_c.transpose() * b.R_w_c;
    t = R_b_a * (a.R_w_c.transpose() * (b.t_w_c - a.t_w_c) - T_a_b.translation().cast<T>());
  }

  /// Logarithm in SE(3): [V(w)^-1 t; w] with w that of the rotation.
  Vector6<T> Log() const {
    Vector3<T> w;
    ceres::RotationMatrixToAngleAxis(R.data(), w.data());
    const T angle2 = w.squaredNorm();
    // V^-1 = I - W / 2 + c W^2 with c = (1 - angle / 2 cot(angle / 2)) / angle^2; the series is exact to 1e-16 below.
    T c = 1.0 / 12.0 + angle2 * (1.0 / 720.0 + angle2 / 30240.0);
    if (angle2 > T(1e-3)) {
      using std::sqrt;
      using std::tan;
      const T half = 0.5 * sqrt(angle2);
      c = (1.0 - half / tan(half)) / angle2;
    }
    const Vector3<T> wt = w.cross(t);
    Vector6<T> log;
    log << t - 0.5 * wt + c * w.cross(wt), w;
    return log;
  }

  Matrix3<T> R;
  Vector3<T> t;
};

/// Relative motion of two keyframes (`RelativePoseCost`): L^-1 Log(E), with L L^T the covariance of the motion's right
/// perturbation. Parameters: both poses.
struct MotionFunctor {
  MotionFunctor(const RelativePose& measured, const SE3& start_a_in, const SE3& start_b_in)
      : T_a_b(measured.T_a_b),
        start_a(start_a_in),
        start_b(start_b_in),
        L_inverse(measured.covariance.llt().matrixL().solve(Matrix6d::Identity())) {}

  template <typename T>
  bool operator()(const T* a, const T* b, T* residuals) const {
    const MotionError<T> error(T_a_b, PoseAt<T>(start_a, a), PoseAt<T>(start_b, b));
    Eigen::Map<Vector6<T>>{residuals} = L_inverse.cast<T>() * error.Log();
    return true;
  }

  SE3 T_a_b;
  SE3 start_a;
  SE3 start_b;
  Matrix6d L_inverse;
};

/// Edge of a pose graph (`PoseGraphMotion`), a loop or a motion: U [t; 2 vec(q)] of E, with q its unit quaternion of
/// w >= 0 and U^T U the information. Parameters: both poses.
struct EdgeFunctor {
  EdgeFunctor(const SE3& T_a_b_in, const Matrix6d& information, const SE3& start_a_in, const SE3& start_b_in)
      : T_a_b(T_a_b_in), start_a(start_a_in), start_b(start_b_in), U(information.llt().matrixU()) {}

  template <typename T>
  bool operator()(const T* a, const T* b, T* residuals) const {
    const MotionError<T> error(T_a_b, PoseAt<T>(start_a, a), PoseAt<T>(start_b, b));
    Eigen::Quaternion<T> q(error.R);
    if (q.w() < T(0.0)) q.coeffs() = -q.coeffs();
    Vector6<T> e;
    e << error.t, 2.0 * q.vec();
    Eigen::Map<Vector6<T>>{residuals} = U.cast<T>() * e;
    return true;
  }

  SE3 T_a_b;
  SE3 start_a;
  SE3 start_b;
  Matrix6d U;
};

/// Edge of a pose graph in the plane: U [t; angle] of E. Parameters: [x, y, angle] of both poses.
struct PlanarEdgeFunctor {
  PlanarEdgeFunctor(double angle_in, const Eigen::Vector2d& t, const Eigen::Matrix3d& information)
      : angle(angle_in), t_a_b(t), U(information.llt().matrixU()) {}

  template <typename T>
  bool operator()(const T* a, const T* b, T* residuals) const {
    using std::atan2;
    using std::cos;
    using std::sin;
    const auto turned_back = [](const T& by, const Eigen::Matrix<T, 2, 1>& v) {
      return Eigen::Matrix<T, 2, 1>(cos(by) * v.x() + sin(by) * v.y(), -sin(by) * v.x() + cos(by) * v.y());
    };
    const Eigen::Matrix<T, 2, 1> step(b[0] - a[0], b[1] - a[1]);
    const Eigen::Matrix<T, 2, 1> t = turned_back(T(angle), turned_back(a[2], step) - t_a_b.cast<T>());
    const T turn = b[2] - a[2] - angle;
    const Vector3<T> e(t.x(), t.y(), atan2(sin(turn), cos(turn)));
    Eigen::Map<Vector3<T>>{residuals} = U.cast<T>() * e;
    return true;
  }

  double angle;
  Eigen::Vector2d t_a_b;
  Eigen::Matrix3d U;
};

/// Prior of a parameter block: W (x - mean), with W the square root of the information.
template <int N>
struct PriorFunctor {
  Eigen::Matrix<double, N, 1> mean;
  Eigen::Matrix<double, N, N> W;

  template <typename T>
  bool operator()(const T* x, T* residuals) const {
    Eigen::Map<Eigen::Matrix<T, N, 1>>{residuals} =
        W.template cast<T>() * (Eigen::Map<const Eigen::Matrix<T, N, 1>>(x) - mean.template cast<T>());
    return true;
  }
};

}  // namespace plslam::reference
