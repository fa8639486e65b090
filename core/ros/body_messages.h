// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "core/robot/body_pose.h"
#include "core/ros/ros_messages.h"

namespace plslam {

/// The frames of a robot (REP 105), by the names that it gives them: the map, the odometry and the body, with the axes
/// of the body (`robot::BodyPose`).
struct RobotFrames {
  std::string map = "map";
  std::string odom = "odom";
  std::string body = "base_link";
  std::string camera = kRosCamera;  ///< rectified left camera
  /// Which transforms are written: map to odom, odom to the body, and, once, the body to the camera.
  bool writes_map = true;
  bool writes_odom = true;
  bool writes_camera = true;
};

// Contents of messages of a body's pose, for any encoding. Names of frames are those of `frames`, which must live on.

/// The body in odom. An unknown velocity is 0 with variances of 1e6.
RosOdometry BodyOdometry(const robot::BodyPose& pose, const RobotFrames& frames);
RosOdometry BodyOdometry(const robot::BodyPose& pose, RobotFrames&& frames) = delete;
/// Returns the transforms from map to odom, if that is known, and from odom to the body.
std::vector<RosTransform> BodyTransforms(const robot::BodyPose& pose, const RobotFrames& frames);
std::vector<RosTransform> BodyTransforms(const robot::BodyPose& pose, RobotFrames&& frames) = delete;

}  // namespace plslam
