// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <functional>
#include <optional>
#include <string>
#include <utility>

#include "core/datasets/calibrations/camera_info.h"
#include "core/geometry/se3.h"
#include "core/geometry/static_frames.h"
#include "core/robot/stamp_pairing.h"

namespace plslam::ros2 {

/// The newest CameraInfo of each side until it is used, and where the cameras are by /tf_static.
///
/// A rig that changed while it is in use would begin a new session, so the first one waits for /tf_static for a while:
/// longer where it has a publisher, which other processes of the robot may become after the camera.
class HeldInfos {
 public:
  /// Time in which /tf_static is awaited after the first CameraInfo: some publishers repeat what late subscribers lack
  /// every three seconds.
  static constexpr double kPatience_s = 5.0;
  /// The same without a publisher of /tf_static: time in which one is discovered.
  static constexpr double kDiscovery_s = 2.0;

  /// The state of the rig in use.
  struct Rig {
    bool is_rgbd = false;  ///< depths have no CameraInfo of their own
    bool is_known = false;
    std::string imu_frame;  ///< of the inertial sensor; empty: not known
    bool needs_imu_pose = false;
  };
  struct Ready {
    RosCameraInfo left;
    std::optional<RosCameraInfo> right;
    std::optional<SE3> T_b_l;    ///< nullopt: /tf_static does not have the left camera
    std::optional<SE3> T_l_imu;  ///< nullopt: nor the inertial sensor
  };

  /// `body`: the frame of the robot's body.
  explicit HeldInfos(std::string body) : body_(std::move(body)) {}

  /// `frame`: that of the images.
  void Add(robot::Side side, RosCameraInfo info, const std::string& frame, double now_s);
  /// A transform of /tf_static.
  void AddFrame(const std::string& parent, const std::string& child, const SE3& T_parent_child) {
    frames_.Add(parent, child, T_parent_child);
  }

  /// Takes the infos if both sides have one, and do not wait for frames. `has_publisher`: whether /tf_static has one.
  std::optional<Ready> Take(const Rig& rig, double now_s, const std::function<bool()>& has_publisher);

  /// Whether the infos wait for /tf_static.
  bool awaits_frames() const { return awaits_frames_; }
  /// The frame of the left images.
  const std::string& left_frame() const { return left_frame_; }

 private:
  std::string body_;
  StaticFrames frames_;
  std::string left_frame_;
  std::array<std::optional<RosCameraInfo>, 2> infos_;
  double since_s_ = 0.0;  ///< of the first of `infos_`
  bool awaits_frames_ = false;
};

}  // namespace plslam::ros2
