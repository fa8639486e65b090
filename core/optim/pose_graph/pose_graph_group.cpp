// SPDX-License-Identifier: BSD-3-Clause
#include "core/optim/pose_graph/pose_graph_group.h"

namespace plslam {

SE3 PoseGroup<SE3>::Plus(const SE3& pose, const double* step) {
  const Eigen::Map<const Eigen::Vector3d> move(step);
  const Eigen::Map<const Eigen::Vector3d> turn(step + 3);
  return SE3(pose.rotation() * ExpSO3(turn), pose.translation() + pose.rotation() * move);
}

PoseEdgeError<SE3> PoseGroup<SE3>::Error(const SE3& T_a_b, const SE3& a, const SE3& b) {
  const SE3 D = a.Inverse() * b;
  const SE3 E = T_a_b.Inverse() * D;
  const double sign = E.rotation().w() < 0.0 ? -1.0 : 1.0;
  const double w = sign * E.rotation().w();
  const Eigen::Vector3d v = sign * E.rotation().vec();
  const Eigen::Matrix3d R_b_a = T_a_b.R().transpose();
  PoseEdgeError<SE3> error;
  error.e << E.translation(), 2.0 * v;
  error.by_a.setZero();
  error.by_a.topLeftCorner<3, 3>() = -R_b_a;
  error.by_a.topRightCorner<3, 3>() = R_b_a * Skew(D.translation());
  error.by_a.bottomRightCorner<3, 3>() = (Skew(v) - w * Eigen::Matrix3d::Identity()) * R_b_a;
  error.by_b.setZero();
  error.by_b.topLeftCorner<3, 3>() = E.R();
  error.by_b.bottomRightCorner<3, 3>() = Skew(v) + w * Eigen::Matrix3d::Identity();
  return error;
}

SE2 PoseGroup<SE2>::Plus(const SE2& pose, const double* step) {
  return SE2(WrapAngle(pose.angle() + step[2]), pose.translation() + pose.R() * Eigen::Vector2d(step[0], step[1]));
}

PoseEdgeError<SE2> PoseGroup<SE2>::Error(const SE2& T_a_b, const SE2& a, const SE2& b) {
  const SE2 D = a.Inverse() * b;
  const Eigen::Matrix2d R_b_a = T_a_b.R().transpose();
  const Eigen::Vector2d quarter_turn(-D.translation().y(), D.translation().x());
  PoseEdgeError<SE2> error;
  error.e << R_b_a * (D.translation() - T_a_b.translation()), WrapAngle(D.angle() - T_a_b.angle());
  error.by_a.setZero();
  error.by_a.topLeftCorner<2, 2>() = -R_b_a;
  error.by_a.topRightCorner<2, 1>() = -R_b_a * quarter_turn;
  error.by_a(2, 2) = -1.0;
  error.by_b.setZero();
  error.by_b.topLeftCorner<2, 2>() = R_b_a * D.R();
  error.by_b(2, 2) = 1.0;
  return error;
}

}  // namespace plslam
