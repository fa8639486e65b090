// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>

#include <opencv2/core/mat.hpp>

#include <robotPubSubTypes.h>
#include "core/geometry/calibration.h"
#include "core/geometry/imu.h"
#include "core/geometry/se3.h"

namespace plslam::test {

// Messages as drivers of ROS 2 write them.

void SetHeader(std_msgs::msg::dds_::Header_& header, int64_t t_ns, const char* frame);
int64_t StampOf(const std_msgs::msg::dds_::Header_& header);

/// A grey image, or depths in millimetres.
sensor_msgs::msg::dds_::Image_ ImageOf(const cv::Mat& grey, int64_t t_ns);
/// The same as a file: "jpeg", "png", or "compressedDepth" (PNG after 12 bytes).
sensor_msgs::msg::dds_::CompressedImage_ CompressedOf(const cv::Mat& image, const std::string& format, int64_t t_ns);
/// A camera of a rig with plumb_bob lenses, and its place in the rectified pair.
sensor_msgs::msg::dds_::CameraInfo_ InfoOf(const RigCalibration& rig, bool is_left, int64_t t_ns);
/// The pose of a body whose camera looks along x, relative to that of the first frame; from true poses.
nav_msgs::msg::dds_::Odometry_ OdometryOf(const SE3& T_first_c, int64_t t_ns);
sensor_msgs::msg::dds_::Imu_ ImuOf(const ImuSample& sample, int64_t t_ns);
/// /tf_static of a robot: the left camera is 0.3 m in front of the body's origin and 0.2 m above it, and looks to the
/// left. The first transform, of another frame, has no rotation and is invalid.
tf2_msgs::msg::dds_::TFMessage_ MountingOf(const RigCalibration& rig);

}  // namespace plslam::test
