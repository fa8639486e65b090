// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <numbers>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "core/optim/pose_graph/pose_graph.h"

namespace plslam {

/// Operations that differ between pose graphs in space and in the plane. Perturbations act on the right, to first order
/// [translation; rotation].
template <class Pose>
struct PoseGroup;

/// Error of an edge and its derivatives by the right perturbations of both poses.
template <class Pose>
struct PoseEdgeError {
  Eigen::Matrix<double, kPoseFreedom<Pose>, 1> e;
  PoseMatrix<Pose> by_a;
  PoseMatrix<Pose> by_b;
};

template <>
struct PoseGroup<SE3> {
  static constexpr int kDimension = 3;

  static SE3 Plus(const SE3& pose, const double* step);
  static SE3 FromRotation(const Eigen::Matrix3d& R, const Eigen::Vector3d& t) { return SE3(R, t); }
  static PoseEdgeError<SE3> Error(const SE3& T_a_b, const SE3& a, const SE3& b);
};

template <>
struct PoseGroup<SE2> {
  static constexpr int kDimension = 2;

  static SE2 Plus(const SE2& pose, const double* step);
  static SE2 FromRotation(const Eigen::Matrix2d& R, const Eigen::Vector2d& t) {
    return SE2(std::atan2(R(1, 0), R(0, 0)), t);
  }
  static PoseEdgeError<SE2> Error(const SE2& T_a_b, const SE2& a, const SE2& b);
};

/// Returns e^T information e, with the error e of the edge.
template <class Pose>
double EdgeChi2(const PoseGraphMotion<Pose>& edge, const std::vector<Pose>& T_w_kf) {
  const auto e = PoseGroup<Pose>::Error(edge.T_a_b, T_w_kf[edge.a], T_w_kf[edge.b]).e;
  return e.dot(edge.information * e);
}

}  // namespace plslam
