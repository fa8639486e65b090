// SPDX-License-Identifier: BSD-3-Clause
#include "core/robot/body_pose.h"

namespace plslam::robot {
namespace {

/// The covariance of a right perturbation in c, as one in b.
Matrix6d Moved(const SE3& T_b_c, const Matrix6d& covariance) {
  const Matrix6d A = T_b_c.Adjoint();
  return A * covariance * A.transpose();
}

}  // namespace

Matrix6d AlongParentAxes(const SE3& T_parent_child, const Matrix6d& covariance) {
  Matrix6d turn = Matrix6d::Zero();
  turn.topLeftCorner<3, 3>() = turn.bottomRightCorner<3, 3>() = T_parent_child.R();
  return turn * covariance * turn.transpose();
}

BodyPose ToBody(const SE3& T_b_c, const CameraPose& camera) {
  const SE3 T_c_b = T_b_c.Inverse();
  const auto of_body = [&](const SE3& T) { return T_b_c * T * T_c_b; };
  BodyPose body;
  body.t_ns = camera.t_ns;
  body.anchored = camera.anchored;
  body.T_map_odom = of_body(camera.T_w_odom);
  body.T_odom_b = of_body(camera.T_odom_c);
  body.T_map_b = body.T_map_odom * body.T_odom_b;
  body.covariance = AlongParentAxes(body.T_odom_b, Moved(T_b_c, camera.covariance));
  if (!camera.dt_s) return body;
  const double rate = 1.0 / *camera.dt_s;
  body.velocity = rate * of_body(camera.T_prev_c).Log();
  body.velocity_covariance = rate * rate * Moved(T_b_c, camera.motion_covariance);
  return body;
}

}  // namespace plslam::robot
