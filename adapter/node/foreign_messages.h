// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "bot_core/pose_t.hpp"
#include "core/datasets/recordings/ros_messages.h"
#include "core/geometry/imu.h"
#include "core/map/map.h"
#include "core/robot/body_pose.h"
#include "core/robot/foreign_image.h"
#include "core/ros/ros_messages.h"
#include "nav_msgs/Odometry.hpp"
#include "sensor_msgs/PointCloud2.hpp"
#include "tf2_msgs/TFMessage.hpp"

namespace plslam::adapter {

// Conversion of other programs' messages to values and back. Received bytes are checked: types by their fingerprints,
// sizes, stamps. Invalid bytes throw DatasetError with a phrase to follow the name of the channel ("has no ...").

using MessageBytes = std::span<const uint8_t>;

/// Whether they begin as a message of a type that holds images does.
bool IsOfImages(MessageBytes bytes);
/// Left and right image of a `bot_core.images_t`, in any order among others.
std::pair<robot::ForeignImage, robot::ForeignImage> PairFromBytes(MessageBytes bytes);
/// A `sensor_msgs.Image` or `sensor_msgs.CompressedImage`.
robot::ForeignImage ImageFromBytes(MessageBytes bytes);
/// A `sensor_msgs.CameraInfo`.
RosCameraInfo CameraInfoFromBytes(MessageBytes bytes);

/// Pose of the robot's body in a `nav_msgs.Odometry`, in the robot's own frame.
struct RobotPose {
  int64_t t_ns = 0;
  SE3 T_robot_b;
};
RobotPose RobotPoseFromBytes(MessageBytes bytes);

/// A sample of an inertial sensor: sensor_msgs.Imu, bot_core.ins_t or microstrain.ins_t.
ImuSample ImuSampleFromBytes(MessageBytes bytes);

/// The body in map; velocities in the body's axes. The accelerations are 0.
bot_core::pose_t ToBotPose(const robot::BodyPose& pose);
/// In the types of LCM.
nav_msgs::Odometry ToOdometry(const RosOdometry& odometry);
tf2_msgs::TFMessage ToTransforms(int64_t t_ns, const std::vector<RosTransform>& transforms);
/// The points of a map in the frame map: x, y, z in 32 bits.
sensor_msgs::PointCloud2 ToPointCloud(const SE3& T_b_c, const Map& map, int64_t t_ns);

}  // namespace plslam::adapter
