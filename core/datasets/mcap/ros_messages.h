// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <opencv2/core/mat.hpp>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/geometry/calibration.h"
#include "core/geometry/se3.h"

namespace plslam {

// Messages of ROS 2 in CDR, as far as a stereo sequence needs them. All throw DatasetError where one is damaged.

/// Names of the types, as schemas have them.
inline constexpr std::string_view kRosImage = "sensor_msgs/msg/Image";
inline constexpr std::string_view kRosCompressedImage = "sensor_msgs/msg/CompressedImage";
inline constexpr std::string_view kRosCameraInfo = "sensor_msgs/msg/CameraInfo";
inline constexpr std::string_view kRosOdometry = "nav_msgs/msg/Odometry";
inline constexpr std::string_view kRosPose = "geometry_msgs/msg/PoseStamped";

/// sensor_msgs/msg/CameraInfo.
struct RosCameraInfo {
  int width_px = 0, height_px = 0;
  std::string model;
  std::vector<double> distortion;
  Eigen::Matrix3d K, R;
  Eigen::Matrix<double, 3, 4> P;
};
RosCameraInfo ParseCameraInfo(std::span<const uint8_t> cdr);

/// Grey pixels of an Image or a CompressedImage (`type`).
cv::Mat ParseImage(std::string_view type, std::span<const uint8_t> cdr, const cv::Size& expected);

/// Pose of an Odometry or a PoseStamped (`type`).
SE3 ParsePose(std::string_view type, std::span<const uint8_t> cdr);

/// The rig of two cameras. Images are `rectified`: then P describes them, else K and D do, and R tells how the
/// cameras are turned. The baseline is that of P, where ROS has it (P[3] = -fx b). Throws DatasetError for lenses
/// that have no counterpart here, and where there is no baseline.
RigCalibration RigFromRos(const RosCameraInfo& left, const RosCameraInfo& right, bool rectified);

}  // namespace plslam
