// SPDX-License-Identifier: BSD-3-Clause
#include "vo_process/node/frame_inputs.h"

#include <vector>

namespace plslam::vo {

FrameInputs::FrameInputs(bus::Process& process, const VoOptions& options, const std::function<void()>& on_arrival) {
  if (options.masks.enabled) masks_.emplace(process, options.masks, on_arrival);
  if (options.robot_motion.enabled) robot_.emplace(process, on_arrival);
  if (options.imu.enabled) imu_.emplace(process, options.imu, on_arrival);
}

void FrameInputs::OnCamera(const RigCalibration& rig) {
  if (robot_) robot_->OnCamera(rig);
  imu_offset_ns_.reset();
  if (rig.imu) imu_offset_ns_ = rig.imu->offset_ns();
}

bool FrameInputs::Awaits(const Frame& frame, const std::optional<int64_t>& prev_t_ns, bool queue_is_full) {
  const int64_t t_ns = frame.images.t_ns;
  if (robot_ && robot_->Awaits(t_ns, frame.lockstep)) return true;
  const bool has_motion = imu_ && imu_offset_ns_ && prev_t_ns && *prev_t_ns < t_ns;
  if (has_motion && imu_->Awaits(frame.source, *prev_t_ns, t_ns, frame.lockstep, frame.came_s)) return true;
  return masks_ && (frame.lockstep || !queue_is_full) &&
         masks_->Awaits({frame.images.frame_id, t_ns}, frame.lockstep, frame.came_s);
}

void FrameInputs::Use(const Frame& frame, int64_t prev_t_ns, StereoFrontEnd& front_end, Odometry& odometry,
                      TrackerReport& report) {
  const int64_t t_ns = frame.images.t_ns;
  if (masks_) {
    const std::optional<FrameMask> mask = masks_->Take({frame.images.frame_id, t_ns});
    if (!mask) report.Count("masks.missing", 1);
    front_end.SetMask(mask.value_or(FrameMask()));
  }
  if (robot_) {
    const std::optional<RobotMotion> motion =
        robot_->Take(odometry.motion().robot().MeasuredAt(prev_t_ns), prev_t_ns, t_ns);
    if (!motion) report.Count("robot_motions.missing", 1);
    odometry.ExpectRobot(motion);
  }
  if (imu_ && imu_offset_ns_) {
    const int64_t needed_ns = odometry.motion().inertial().NeededFrom(prev_t_ns);
    const std::vector<ImuSample> samples = imu_->Take(needed_ns, t_ns, *imu_offset_ns_);
    odometry.ExpectImu(samples, prev_t_ns, t_ns);
  }
}

}  // namespace plslam::vo
