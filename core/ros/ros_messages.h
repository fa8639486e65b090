// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/geometry/calibration.h"
#include "core/geometry/se3.h"
#include "core/io/trajectories/trajectory.h"
#include "core/map/map.h"

namespace plslam {

// Messages of ROS 2, in CDR. The name in front of each type is that of the C++ function; times are of the data.

/// geometry_msgs/msg/TransformStamped in tf2_msgs/msg/TFMessage: p_parent = T_parent_child p_child.
std::string RosTransform(int64_t t_ns, std::string_view parent, std::string_view child, const SE3& T_parent_child);

/// Odometry of a frame. Covariances here are of right perturbations [translation; rotation], as everywhere in plslam;
/// ROS's covariance of the pose is along the axes of the map, and is the same one rotated.
struct RosOdometry {
  int64_t t_ns = 0;
  SE3 T_w_l;
  Matrix6d covariance = Matrix6d::Zero();
  /// Linear and angular, in l, and the covariance.
  Vector6d velocity = Vector6d::Zero();
  Matrix6d velocity_covariance = Matrix6d::Zero();
};
/// nav_msgs/msg/Odometry in `map`, of `camera_left`.
std::string RosOdometryMessage(const RosOdometry& odometry);

/// nav_msgs/msg/Path, in `map`, and geometry_msgs/msg/PoseArray of the same poses.
std::string RosPath(int64_t t_ns, const Trajectory& trajectory);
std::string RosPoseArray(int64_t t_ns, const Trajectory& trajectory);

/// sensor_msgs/msg/CompressedImage of an image file; `format` is "jpeg" or "png".
std::string RosCompressedImage(int64_t t_ns, const std::string& format, std::string_view file);
/// sensor_msgs/msg/CameraInfo of the image as recorded: distortion models plumb_bob and equidistant.
std::string RosCameraInfoMessage(int64_t t_ns, const CameraCalibration& camera);

/// sensor_msgs/msg/PointCloud2: x, y, z and colour as in map.ply, and `observations`, the number of keyframes that
/// see the point.
std::string RosPoints(int64_t t_ns, const Map& map);
/// visualization_msgs/msg/Marker, LINE_LIST: the segments, coloured as in map.ply.
std::string RosLines(int64_t t_ns, const Map& map);
/// The same: from keyframe to keyframe of each loop that was closed.
std::string RosLoops(int64_t t_ns, const Map& map);

/// diagnostic_msgs/msg/DiagnosticArray of one status: level 0 fine, 1 warning, 2 error.
struct RosDiagnostic {
  int64_t t_ns = 0;
  int level = 0;
  std::string name;
  std::string message;
  std::vector<std::pair<std::string, std::string>> values;
};
std::string RosDiagnosticMessage(const RosDiagnostic& diagnostic);

}  // namespace plslam
