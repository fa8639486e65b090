// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include "core/geometry/calibration.h"
#include "core/geometry/se3.h"
#include "core/io/files/bytes.h"
#include "core/io/trajectories/trajectory.h"
#include "core/map/map.h"

namespace plslam::exports {

/// A message of ROS 2 as serialised by its middleware: CDR (OMG DDS-XTypes, plain CDR), little endian. Numbers are
/// aligned to their size, counted from after the four bytes that name the encoding; members follow each other without
/// other bytes in between.
class CdrWriter {
 public:
  template <class Number>
  void Put(Number value) {
    static_assert(std::is_arithmetic_v<Number>);
    const size_t from = (bytes_.size() - kHeadBytes) % sizeof(Number);
    if (from != 0) bytes_.append(sizeof(Number) - from, '\0');
    AppendLittleEndian(value, bytes_);
  }

  void Put(std::string_view text) {
    Put(static_cast<uint32_t>(text.size() + 1));
    bytes_.append(text).push_back('\0');
  }
  void Put(const char* text) { Put(std::string_view(text)); }

  /// Appends the number of elements before a sequence.
  void PutCount(size_t n) { Put(static_cast<uint32_t>(n)); }

  /// A sequence of bytes.
  void PutBytes(std::string_view bytes) {
    PutCount(bytes.size());
    bytes_.append(bytes);
  }

  std::string Take() && { return std::move(bytes_); }

 private:
  static constexpr size_t kHeadBytes = 4;

  std::string bytes_{"\0\1\0\0", kHeadBytes};
};

/// The definition of a message type of ROS 2, "nav_msgs/msg/Path", with all types that it is made of, as schemas of
/// MCAP (encoding ros2msg) have it. Throws std::out_of_range for types that no export writes.
std::string RosDefinition(const std::string& type);

// Messages of ROS 2, in CDR. The name in front of each type is that of the C++ function; times are of the data.

/// Coordinate frames of the exported messages. `kRosWorld` is level, z up; the others are those of docs/frames.md: w,
/// and l.
inline constexpr const char* kRosWorld = "world";
inline constexpr const char* kRosMap = "map";
inline constexpr const char* kRosCamera = "camera_left";

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

}  // namespace plslam::exports
