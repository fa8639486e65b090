// SPDX-License-Identifier: BSD-3-Clause
#include "core/ros/body_messages.h"

namespace plslam {

RosOdometry BodyOdometry(const robot::BodyPose& pose, const RobotFrames& frames) {
  constexpr double kUnknownVariance = 1e6;
  RosOdometry odometry;
  odometry.t_ns = pose.t_ns;
  odometry.parent = frames.odom;
  odometry.child = frames.body;
  odometry.T_parent_child = pose.T_odom_b;
  odometry.covariance = pose.covariance;
  odometry.velocity = pose.velocity.value_or(Vector6d::Zero());
  odometry.velocity_covariance =
      pose.velocity ? pose.velocity_covariance : Matrix6d(kUnknownVariance * Matrix6d::Identity());
  return odometry;
}

std::vector<RosTransform> BodyTransforms(const robot::BodyPose& pose, const RobotFrames& frames) {
  std::vector<RosTransform> transforms;
  if (frames.writes_map && pose.anchored) transforms.push_back({frames.map, frames.odom, pose.T_map_odom});
  if (frames.writes_odom) transforms.push_back({frames.odom, frames.body, pose.T_odom_b});
  return transforms;
}

}  // namespace plslam
