// SPDX-License-Identifier: BSD-3-Clause
#include "vo_process/node/unused_inputs.h"

#include "plslam/mask_t.hpp"
#include "plslam/robot_motion_t.hpp"

namespace plslam::vo {

void WarnOfUnusedInputs(bus::Process& process, const VoOptions& options) {
  if (!options.masks.enabled) {
    process.bus().SubscribeBestEffort<mask_t>(bus::kMask, [&process](const mask_t&) {
      process.Warn("masks_unused", "masks arrive and are not used: set vo.masks.enabled=true");
    });
  }
  if (!options.robot_motion.enabled) {
    process.bus().SubscribeBestEffort<robot_motion_t>(bus::kRobotMotion, [&process](const robot_motion_t&) {
      process.Warn("robot_motion_unused",
                   "poses of the robot arrive and are not used: set vo.robot_motion.enabled=true");
    });
  }
}

}  // namespace plslam::vo
