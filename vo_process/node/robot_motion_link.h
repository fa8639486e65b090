// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <functional>
#include <optional>

#include "core/geometry/calibration.h"
#include "core/process/partner_wait.h"
#include "core/process/process.h"
#include "vo_process/tracking/motion/robot_motion_model.h"
#include "vo_process/tracking/motion/robot_path.h"

namespace plslam::vo {

/// A tracker's link to the robot's own odometry (channel ROBOT_MOTION). In lockstep a frame waits until a pose at its
/// time or later arrives, or none has been received for `bus.partner_wait_s`; a live frame is tracked with the poses received.
class RobotMotionLink {
 public:
  /// `on_arrival` is called when a pose has arrived, or a wait may be over.
  RobotMotionLink(bus::Process& process, std::function<void()> on_arrival);

  void OnCamera(const RigCalibration& rig);
  /// Whether the frame at this time has to wait.
  bool Awaits(int64_t t_ns, bool lockstep);
  /// Returns the motion from the last measured frame, or else from the previous one, to a frame whose wait is over;
  /// nullopt if both are unknown.
  std::optional<RobotMotion> Take(int64_t measured_t_ns, int64_t prev_t_ns, int64_t t_ns);

 private:
  bus::Process& process_;
  std::function<void()> on_arrival_;
  RobotPath path_;
  SE3 T_b_c_;
  bus::PartnerWait wait_;
  std::optional<int64_t> awaited_t_ns_;
  int n_missing_ = 0;  ///< frames in a row up to which no pose of the robot covers the motion
};

}  // namespace plslam::vo
