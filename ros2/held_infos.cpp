// SPDX-License-Identifier: BSD-3-Clause
#include "ros2/held_infos.h"

namespace plslam::ros2 {

void HeldInfos::Add(robot::Side side, RosCameraInfo info, const std::string& frame, double now_s) {
  if (side == robot::Side::kLeft) left_frame_ = frame;
  if (!infos_[0] && !infos_[1]) since_s_ = now_s;
  infos_[static_cast<size_t>(side)] = std::move(info);
}

std::optional<HeldInfos::Ready> HeldInfos::Take(const Rig& rig, double now_s,
                                                const std::function<bool()>& has_publisher) {
  if (!infos_[0] || (!infos_[1] && !rig.is_rgbd)) return std::nullopt;
  const std::optional<SE3> T_b_l = frames_.Find(body_, left_frame_);
  const bool have_names = !left_frame_.empty() && !rig.imu_frame.empty();
  const std::optional<SE3> T_l_imu = have_names ? frames_.Between(left_frame_, rig.imu_frame) : std::nullopt;
  const bool knows_poses = T_b_l && (T_l_imu || !rig.needs_imu_pose);
  const auto patience_s = [&] { return has_publisher() ? kPatience_s : kDiscovery_s; };
  awaits_frames_ = !knows_poses && !rig.is_known && now_s - since_s_ < patience_s();
  if (awaits_frames_) return std::nullopt;
  auto infos = std::exchange(infos_, {});
  return Ready{*std::move(infos[0]), std::move(infos[1]), T_b_l, T_l_imu};
}

}  // namespace plslam::ros2
