// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>
#include <string_view>

namespace plslam {

/// Coordinate frames of messages of ROS. `kRosWorld` is level, z up; the others are those of docs/frames.md: w, and l.
inline constexpr const char* kRosWorld = "world";
inline constexpr const char* kRosMap = "map";
inline constexpr const char* kRosCamera = "camera_left";

/// When a message of a topic is written.
enum class RosRate {
  kOnce,    ///< at the begin
  kFrame,   ///< for each pose
  kImage,   ///< for each image
  kMap,     ///< after changes of the map or the path, at most once a second
  kStatus,  ///< for each status: of a frame in exports, of a process live
};

/// Quality of service. A late subscriber of a `kLatched` topic receives its last message (reliable, transient local,
/// depth 1); `kReliable` and `kImage` (best effort) keep the last 5.
enum class RosQos { kReliable, kImage, kLatched };

/// A row of the table of topics, which the MCAP export, the Foxglove socket and DDS write. Messages are made by
/// ros_messages.h.
struct RosTopic {
  std::string_view name;
  std::string_view type;
  std::string_view frame;  ///< of the header; empty: none
  RosRate rate = RosRate::kFrame;
  RosQos qos = RosQos::kReliable;
  bool is_live = true;  ///< otherwise only exports of a finished run have it
  std::string_view meaning;
};

namespace ros_topic {

inline constexpr RosTopic kTf{"/tf", "tf2_msgs/msg/TFMessage", kRosMap, RosRate::kFrame, RosQos::kReliable,
                              true,  "map from camera_left"};
inline constexpr RosTopic kTfStatic{
    "/tf_static", "tf2_msgs/msg/TFMessage",         kRosWorld, RosRate::kOnce, RosQos::kLatched,
    true,         "world, which is level, from map"};
inline constexpr RosTopic kOdom{"/odom",
                                "nav_msgs/msg/Odometry",
                                kRosMap,
                                RosRate::kFrame,
                                RosQos::kReliable,
                                true,
                                "pose with covariance along the axes of map; velocity in the camera"};
inline constexpr RosTopic kPose{
    "/pose", "geometry_msgs/msg/PoseWithCovarianceStamped", kRosMap, RosRate::kFrame, RosQos::kReliable,
    true,    "pose in map, with covariance along its axes"};
inline constexpr RosTopic kPath{"/path", "nav_msgs/msg/Path",  kRosMap, RosRate::kMap, RosQos::kLatched,
                                true,    "poses of all frames"};
inline constexpr RosTopic kPathLive{"/path_live",
                                    "nav_msgs/msg/Path",
                                    kRosMap,
                                    RosRate::kOnce,
                                    RosQos::kLatched,
                                    false,
                                    "poses as they were in the run"};
inline constexpr RosTopic kPathTruth{"/path_truth", "nav_msgs/msg/Path", kRosMap, RosRate::kOnce, RosQos::kLatched,
                                     false,         "true poses"};
inline constexpr RosTopic kLeftImage{
    "/camera/left/compressed", "sensor_msgs/msg/CompressedImage", kRosCamera, RosRate::kImage, RosQos::kImage, true,
    "left images as recorded"};
inline constexpr RosTopic kLeftInfo{
    "/camera/left/camera_info",      "sensor_msgs/msg/CameraInfo", kRosCamera, RosRate::kImage, RosQos::kImage, true,
    "calibration of the left camera"};
inline constexpr RosTopic kMapPoints{
    "/map/points", "sensor_msgs/msg/PointCloud2",        kRosMap, RosRate::kMap, RosQos::kLatched,
    true,          "points with colour and observations"};
inline constexpr RosTopic kMapLines{
    "/map/lines", "visualization_msgs/msg/Marker", kRosMap, RosRate::kMap, RosQos::kLatched, true, "line segments"};
inline constexpr RosTopic kLoops{
    "/loops", "visualization_msgs/msg/Marker", kRosMap, RosRate::kMap, RosQos::kLatched, true, "closed loops"};
inline constexpr RosTopic kKeyframes{
    "/keyframes", "geometry_msgs/msg/PoseArray", kRosMap, RosRate::kMap, RosQos::kLatched,
    true,         "poses of keyframes"};
inline constexpr RosTopic kSurfaces{"/map/surfaces",
                                    "sensor_msgs/msg/PointCloud2",
                                    kRosMap,
                                    RosRate::kMap,
                                    RosQos::kLatched,
                                    true,
                                    "surface points with grey and normals, from dense_process"};
inline constexpr RosTopic kGrid{"/map/grid",
                                "nav_msgs/msg/OccupancyGrid",
                                kRosMap,
                                RosRate::kMap,
                                RosQos::kLatched,
                                true,
                                "occupancy grid of the floor, from dense_process"};
inline constexpr RosTopic kDiagnostics{
    "/diagnostics", "diagnostic_msgs/msg/DiagnosticArray",           "", RosRate::kStatus, RosQos::kReliable,
    true,           "state of each frame (export) or process (live)"};

}  // namespace ros_topic

/// Returns all rows.
std::span<const RosTopic> RosTopics();

}  // namespace plslam
