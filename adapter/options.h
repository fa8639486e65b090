// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>

#include "core/config/fields.h"

namespace plslam::adapter {

/// Which foreign channels are joined to the bus. An output channel that is empty is not published.
struct AdapterOptions {
  std::string foreign_url;
  std::string camera;
  std::string images;
  std::string left;
  std::string right;
  std::string left_info;
  std::string right_info;
  double max_skew_ms = 5.0;
  std::string robot_odometry;
  std::string imu;
  std::string imu_calibration;
  std::string pose = "POSE_BODY";
  std::string odometry = "/odom#nav_msgs.Odometry";
  std::string tf = "/tf#tf2_msgs.TFMessage";
  std::string map = "/map#sensor_msgs.PointCloud2";
};

template <class Visitor>
void VisitFields(Visitor& visit, AdapterOptions& o) {
  visit("foreign_url", o.foreign_url, "LCM URL of the robot; empty: LCM_DEFAULT_URL");
  visit("camera", o.camera, "rig file; empty: sensor_msgs.CameraInfo");
  visit("images", o.images, "channel of bot_core.images_t");
  visit("left", o.left, "channel of left sensor_msgs.Image or CompressedImage");
  visit("right", o.right, "channel of right images");
  visit("left_info", o.left_info, "channel of CameraInfo; empty: beside the images");
  visit("right_info", o.right_info, "channel of the right CameraInfo, likewise");
  visit("max_skew_ms", o.max_skew_ms, Bounds{0, 100}, "largest difference between the stamps of a pair");
  visit("robot_odometry", o.robot_odometry,
        "channel of nav_msgs.Odometry of the wheels, for prediction; empty: none");
  visit("imu", o.imu, "channel of sensor_msgs.Imu, bot_core.ins_t or microstrain.ins_t; empty: none");
  visit("imu_calibration", o.imu_calibration, "file with the keys of `imu` (docs/imu.md); empty: the rig file");
  visit("pose", o.pose, "channel for bot_core.pose_t; empty: none");
  visit("odometry", o.odometry, "channel for nav_msgs.Odometry");
  visit("tf", o.tf, "channel for tf2_msgs.TFMessage");
  visit("map", o.map, "channel for sensor_msgs.PointCloud2");
}

}  // namespace plslam::adapter
