// SPDX-License-Identifier: BSD-3-Clause
#include "vo_process/node/robot_motion_link.h"

#include <chrono>
#include <utility>

#include "core/bus/messages/convert.h"
#include "core/bus/run_loop.h"
#include "core/geometry/body_frame.h"
#include "plslam/robot_motion_t.hpp"

namespace plslam::vo {
namespace {

// Period of checks of waits.
constexpr std::chrono::milliseconds kRobotTick(100);
// Frames in a row without a pose of the robot after which that is reported.
constexpr int kReportAfter = 20;
constexpr const char* kNoMotion =
    "poses of the robot do not arrive (vo.robot_motion.enabled, channel ROBOT_MOTION), so frames are tracked without "
    "them: does adapter receive the robot's odometry (adapter.robot_odometry), and has it the same prefix?";

}  // namespace

RobotMotionLink::RobotMotionLink(bus::Process& process, std::function<void()> on_arrival)
    : process_(process), on_arrival_(std::move(on_arrival)), wait_(process.bus().options().partner_wait_s) {
  process.bus().Subscribe<robot_motion_t>(bus::kRobotMotion, [this, &process](const robot_motion_t& message) {
    const std::optional<SE3> T_robot_b = bus::FromMessage(message.T_robot_b);
    if (!T_robot_b) return process.bus().CountRejected();
    wait_.OnSignOfLife(bus::NowS());
    path_.Add(message.header.t_ns, *T_robot_b);
    on_arrival_();
  });
  process.bus().Every(kRobotTick, [this] {
    if (!wait_.GiveUp(bus::NowS())) return;
    process_.Warn("robot_motion_missing", kNoMotion);
    on_arrival_();
  });
}

void RobotMotionLink::OnCamera(const RigCalibration& rig) { T_b_c_ = BodyFromCamera(rig); }

bool RobotMotionLink::Awaits(int64_t t_ns, bool lockstep) {
  if (!lockstep || path_.Reaches(t_ns)) return false;
  if (std::exchange(awaited_t_ns_, t_ns) != t_ns) wait_.Begin(t_ns, bus::NowS());
  return wait_.awaited().has_value();
}

std::optional<RobotMotion> RobotMotionLink::Take(int64_t measured_t_ns, int64_t prev_t_ns, int64_t t_ns) {
  wait_.End();
  for (const int64_t from_ns : {measured_t_ns, prev_t_ns}) {
    const std::optional<SE3> T_fromb_b = path_.Motion(from_ns, t_ns);
    if (!T_fromb_b) continue;
    n_missing_ = 0;
    return RobotMotion{*T_fromb_b, from_ns != measured_t_ns, T_b_c_};
  }
  if (++n_missing_ == kReportAfter) process_.Warn("robot_motion_missing", kNoMotion);
  return std::nullopt;
}

}  // namespace plslam::vo
