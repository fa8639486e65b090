// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/geometry/calibration.h"
#include "core/geometry/se3.h"
#include "core/io/trajectories/trajectory.h"
#include "core/map/map.h"
#include "core/map/occupancy_grid.h"
#include "core/map/surface_cloud.h"
#include "core/ros/ros_topics.h"

namespace plslam {

// Messages of ROS 2, in CDR. The name in front of each type is that of the C++ function; times are of the data.

/// A transform between two frames: p_parent = T_parent_child p_child.
struct RosTransform {
  std::string_view parent, child;
  SE3 T_parent_child;
};
/// tf2_msgs/msg/TFMessage.
std::string RosTransforms(int64_t t_ns, const std::vector<RosTransform>& transforms);

/// Odometry of a frame. The covariance of the pose is along the axes of the parent frame, as ROS has it; that of the
/// velocity along those of the child.
struct RosOdometry {
  int64_t t_ns = 0;
  std::string_view parent = kRosMap, child = kRosCamera;
  SE3 T_parent_child;
  Matrix6d covariance = Matrix6d::Zero();
  Vector6d velocity = Vector6d::Zero();  ///< linear and angular, in the child
  Matrix6d velocity_covariance = Matrix6d::Zero();
};
/// nav_msgs/msg/Odometry.
std::string RosOdometryMessage(const RosOdometry& odometry);

/// geometry_msgs/msg/PoseWithCovarianceStamped; the covariance is along the axes of `frame`.
std::string RosPoseWithCovariance(int64_t t_ns, std::string_view frame, const SE3& pose, const Matrix6d& covariance);

/// The frame in which maps are written: p_frame = T_frame_w p_w.
struct RosView {
  std::string_view frame = kRosMap;
  std::optional<SE3> T_frame_w{};  ///< nullopt: identity, without any rounding
};

/// nav_msgs/msg/Path, in `frame`, and geometry_msgs/msg/PoseArray of the same poses.
std::string RosPath(int64_t t_ns, std::string_view frame, const Trajectory& trajectory);
std::string RosPoseArray(int64_t t_ns, std::string_view frame, const Trajectory& trajectory);

/// sensor_msgs/msg/CompressedImage of an image file; `format` is "jpeg" or "png".
std::string RosCompressedImage(int64_t t_ns, const std::string& format, std::string_view file);
/// sensor_msgs/msg/CameraInfo of the image as recorded: distortion models plumb_bob and equidistant.
std::string RosCameraInfoMessage(int64_t t_ns, const CameraCalibration& camera);

/// sensor_msgs/msg/PointCloud2: x, y, z and colour as in map.ply, and `observations`, the number of keyframes that
/// see the point.
std::string RosPoints(int64_t t_ns, const Map& map, const RosView& view = {});
/// visualization_msgs/msg/Marker, LINE_LIST: the segments, coloured as in map.ply.
std::string RosLines(int64_t t_ns, const Map& map, const RosView& view = {});
/// The same: from keyframe to keyframe of each loop that was closed.
std::string RosLoops(int64_t t_ns, const Map& map, const RosView& view = {});

/// sensor_msgs/msg/PointCloud2 of surface points in w: x, y, z, `rgb` (grey), and `normal_x`, `normal_y`, `normal_z`
/// towards free space.
std::string RosSurfaces(int64_t t_ns, const std::vector<SurfacePoint>& points_w, const RosView& view = {});

/// nav_msgs/msg/OccupancyGrid: 0 free, 100 occupied, -1 unknown. The origin, at the height of the floor, has the
/// rotation of the level frame.
std::string RosOccupancyGrid(int64_t t_ns, const OccupancyGrid& grid, const RosView& view = {});

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
