// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <functional>
#include <optional>

#include "core/bus/bus.h"
#include "core/geometry/calibration.h"
#include "core/process/partner_wait.h"
#include "vo_process/options.h"
#include "vo_process/tracking/robot_motion_model.h"
#include "vo_process/tracking/robot_path.h"

namespace plslam::vo {

/// A tracker's link to the robot's own odometry (channel ROBOT_MOTION). In lockstep a frame waits until a pose of its
/// time or a later one has come, or nobody has been heard of for `wait_s`; live it is tracked with what is there.
class RobotMotionLink {
 public:
  /// `go_on`: a pose has come, or a wait may be over.
  RobotMotionLink(bus::Bus& bus, const RobotMotionUseOptions& options, std::function<void()> go_on);

  void OnCamera(const RigCalibration& rig);
  /// Whether the frame of this time has to wait.
  bool Awaits(int64_t t_ns, bool lockstep);
  /// The motion from the frame before to one that waits no longer; nullopt where it is not known.
  std::optional<RobotMotion> Take(int64_t prev_t_ns, int64_t t_ns);

 private:
  std::function<void()> go_on_;
  RobotPath path_;
  SE3 T_b_c_;
  bus::PartnerWait wait_;
  std::optional<int64_t> awaited_t_ns_;
};

}  // namespace plslam::vo
