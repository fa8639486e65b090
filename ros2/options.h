// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <string>

#include "core/config/choices.h"
#include "core/config/fields.h"

namespace plslam::ros2 {

/// Transforms that are published: map to odom, odom to the body, both, or none.
enum class PublishedTf { kAll, kMap, kOdom, kNone };
constexpr auto ChoicesOf(PublishedTf) {
  return std::array{Choice{"all", PublishedTf::kAll}, Choice{"map", PublishedTf::kMap},
                    Choice{"odom", PublishedTf::kOdom}, Choice{"none", PublishedTf::kNone}};
}

/// Section `ros2` of the configuration. Names of topics and frames are those of ROS.
struct Ros2Options {
  std::string left;
  std::string right;
  std::string left_info;
  std::string right_info;
  std::string camera;
  double max_skew_ms = 5.0;
  PublishedTf publish_tf = PublishedTf::kAll;
  std::string output_namespace = "/plslam";
  std::string map_frame = "map";
  std::string odom_frame = "odom";
  std::string base_frame = "base_link";
  std::string camera_frame;
  std::string map_file;
  std::string robot_odometry;
  std::string imu;
  std::string imu_calibration;
};

template <class Visitor>
void VisitFields(Visitor& visit, Ros2Options& o) {
  visit("left", o.left, "topic of left images: sensor_msgs/Image, or CompressedImage if it ends with /compressed");
  visit("right", o.right, "topic of right images");
  visit("left_info", o.left_info, "topic of CameraInfo; empty: camera_info beside the images");
  visit("right_info", o.right_info, "topic of the right CameraInfo, likewise");
  visit("camera", o.camera, "rig file; empty: CameraInfo");
  visit("max_skew_ms", o.max_skew_ms, Bounds{0, 100}, "largest difference between the stamps of a pair");
  visit("publish_tf", o.publish_tf, "transforms: map to odom and odom to the body, one of them, or none");
  visit("output_namespace", o.output_namespace, "in front of all topics but /tf and /tf_static; empty: none");
  visit("map_frame", o.map_frame, "frame of the map");
  visit("odom_frame", o.odom_frame, "frame of the odometry");
  visit("base_frame", o.base_frame, "frame of the robot's body");
  visit("camera_frame", o.camera_frame,
        "frame of the rectified left camera; empty: camera_left with the prefix of the body's frame");
  visit("map_file", o.map_file,
        "map file of the services save and load, on the machine of mapping_process; empty: none");
  visit("robot_odometry", o.robot_odometry,
        "topic of nav_msgs/Odometry of the robot's wheels, for prediction (vo.robot_motion.enabled); empty: none");
  visit("imu", o.imu, "topic of sensor_msgs/Imu, or .../gyro/sample beside .../accel/sample; empty: none");
  visit("imu_calibration", o.imu_calibration,
        "file with the keys of `imu` (docs/imu.md); empty: the rig file, and /tf_static");
}

}  // namespace plslam::ros2
