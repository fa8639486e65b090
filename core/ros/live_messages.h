// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>

#include <opencv2/core/mat.hpp>

#include "core/geometry/calibration.h"
#include "core/geometry/se3.h"
#include "core/ids/ids.h"
#include "core/io/trajectories/trajectory.h"
#include "core/map/map.h"
#include "core/map/occupancy_grid.h"
#include "core/map/surface_cloud.h"
#include "core/robot/body_pose.h"
#include "core/ros/body_messages.h"
#include "core/ros/ros_messages.h"
#include "core/ros/ros_topics.h"

namespace plslam {

/// Turns what is known of a running system into messages of the table of topics: as the MCAP export has them, in the
/// frames map (w) and camera_left (l); or in those of a robot.
class LiveMessages {
 public:
  using Write = std::function<void(const RosTopic& topic, int64_t t_ns, std::string cdr)>;

  explicit LiveMessages(Write write, std::optional<RobotFrames> robot = {})
      : write_(std::move(write)), robot_(std::move(robot)) {}

  /// Sets the rig of what follows: nothing but diagnostics is written before. Throws std::runtime_error if it has no
  /// rectification.
  void SetRig(const RigCalibration& rig);
  bool has_rig() const { return left_.has_value(); }
  /// Writes transform, odometry and pose, before the first ones the static frame. A new session begins a new path.
  void AddPose(const robot::CameraPose& pose, SessionId session);
  /// Writes the image as a JPEG, and its calibration. `left` has 8 bits.
  void WriteImage(int64_t t_ns, const cv::Mat& left) const;
  /// Writes points, lines, loops, keyframes and the static frame.
  void WriteMap(const Map& map);
  /// Writes the occupancy grid, if it has cells.
  void WriteGrid(const OccupancyGrid& grid) const;
  /// Writes the surface points, if there are any.
  void WriteSurfaces(const SurfaceCloud& cloud) const;
  /// Writes the path, of 10,000 poses at most: in longer ones every second pose is removed.
  void WritePath() const;
  void WriteDiagnostic(RosDiagnostic diagnostic) const;

 private:
  /// The time of the newest pose: data without time have this one.
  int64_t now_ns() const { return path_.empty() ? 0 : path_.back().t_ns; }
  void WriteStaticFrame(int64_t t_ns, const SE3& T_world_map);
  void WriteCameraPose(const robot::CameraPose& pose);
  void WriteBodyPose(const robot::CameraPose& pose);
  void AddToPath(int64_t t_ns, const SE3& pose);
  RosView View() const;

  Write write_;
  std::optional<RobotFrames> robot_;
  std::optional<CameraCalibration> left_;
  SE3 T_c_l_, T_b_c_;
  bool has_static_frame_ = false;  ///< of this rig
  SessionId session_ = -1;
  int64_t n_poses_ = 0;
  int64_t stride_ = 1;  ///< poses of the session for one of the path
  Trajectory path_;
};

}  // namespace plslam
