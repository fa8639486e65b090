// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <functional>
#include <optional>

#include "core/bus/messages/frame_channel.h"
#include "core/process/process.h"
#include "vo_process/node/imu_link.h"
#include "vo_process/node/mask_link.h"
#include "vo_process/node/robot_motion_link.h"
#include "vo_process/node/tracker_report.h"
#include "vo_process/options.h"
#include "vo_process/stereo/stereo_front_end.h"
#include "vo_process/tracking/odometry.h"

namespace plslam::vo {

/// The inputs of a frame from other messages: its mask, the robot's motion and the samples of the inertial sensor since the
/// previous frame. A frame waits for them as `MaskLink`, `RobotMotionLink` and `ImuLink` say.
class FrameInputs {
 public:
  using Frame = bus::FrameSubscriber::Frame;

  /// `on_arrival` is called when one has arrived, or a wait may be over.
  FrameInputs(bus::Process& process, const VoOptions& options, const std::function<void()>& on_arrival);

  void OnCamera(const RigCalibration& rig);

  /// Whether a frame has to wait. `prev_t_ns` is the time of the previous frame of the session, if there is one. A frame
  /// in real time does not wait for its mask if the queue is full.
  bool Awaits(const Frame& frame, const std::optional<int64_t>& prev_t_ns, bool queue_is_full);

  /// Gives them to a frame whose wait is over.
  void Use(const Frame& frame, int64_t prev_t_ns, StereoFrontEnd& front_end, Odometry& odometry,
           TrackerReport& report);

 private:
  std::optional<MaskLink> masks_;
  std::optional<RobotMotionLink> robot_;
  std::optional<ImuLink> imu_;
  /// Time offset of the rig's sensor.
  std::optional<int64_t> imu_offset_ns_;
};

}  // namespace plslam::vo
