// SPDX-License-Identifier: BSD-3-Clause
#include "vo_process/tracking/motion/robot_path.h"

#include <algorithm>
#include <cstddef>

namespace plslam::vo {
namespace {

// Number of poses kept: 40 s of wheels at 100 Hz, more than frames ever wait.
constexpr size_t kMostPoses = 4096;
// A time stamp that goes back by this much belongs to another run, of a clock or of a recording.
constexpr double kAnotherRun_s = 1.0;
// Longest interval between interpolated poses: slow wheels send 10 a second, and some are lost.
constexpr double kLongestGap_s = 0.3;
// Longest extrapolation beyond the newest pose: live frames do not wait for the robot, whose poses arrive a little
// late. Slow wheels are extrapolated for an interval and a half; at 2 m/s^2 and 10 Hz that costs 22 mm until the next
// pose has arrived.
constexpr double kLeastAhead_s = 0.06;
constexpr double kMostAhead_s = 0.2;
constexpr double kIntervalsAhead = 1.5;
// Shortest interval from which the motion is extrapolated; over a shorter one, jitter of time stamps would be
// amplified.
constexpr double kLeastSpan_s = 0.02;
// Limits of a robot's motion, beyond which its odometry was restarted. Time stamps have a resolution of a millisecond.
constexpr double kFastest_m_s = 60.0;
constexpr double kFastestTurn_rad_s = 30.0;
constexpr double kFineness_s = 1e-3;

/// Unsigned: time stamps may have any value. `later_ns` must not be earlier.
double SecondsBetween(int64_t earlier_ns, int64_t later_ns) {
  return 1e-9 * static_cast<double>(static_cast<uint64_t>(later_ns) - static_cast<uint64_t>(earlier_ns));
}

}  // namespace

void RobotPath::Add(int64_t t_ns, const SE3& T_robot_b) {
  const Pose pose{t_ns, T_robot_b};
  if (Reaches(t_ns)) {
    if (SecondsBetween(t_ns, poses_.back().t_ns) < kAnotherRun_s) return;
    poses_.clear();
  }
  if (!poses_.empty() && IsJump(poses_.back(), pose)) poses_.clear();
  poses_.push_back(pose);
  if (poses_.size() > kMostPoses) poses_.pop_front();
}

bool RobotPath::IsJump(const Pose& before, const Pose& after) {
  const double dt_s = std::max(SecondsBetween(before.t_ns, after.t_ns), kFineness_s);
  const SE3 motion = before.T_robot_b.Inverse() * after.T_robot_b;
  return motion.translation().norm() > kFastest_m_s * dt_s ||
         motion.Log().tail<3>().norm() > kFastestTurn_rad_s * dt_s;
}

std::optional<SE3> RobotPath::Motion(int64_t from_ns, int64_t to_ns) const {
  if (from_ns >= to_ns) return std::nullopt;
  const std::optional<SE3> T_robot_from = At(from_ns), T_robot_to = At(to_ns);
  if (!T_robot_from || !T_robot_to) return std::nullopt;
  return T_robot_from->Inverse() * *T_robot_to;
}

/// Returns the pose at a time after `a`, on the motion from there through `b`.
SE3 RobotPath::Between(const Pose& a, const Pose& b, int64_t t_ns) {
  const double share = SecondsBetween(a.t_ns, t_ns) / SecondsBetween(a.t_ns, b.t_ns);
  return a.T_robot_b * SE3::Exp(share * (a.T_robot_b.Inverse() * b.T_robot_b).Log());
}

std::optional<SE3> RobotPath::At(int64_t t_ns) const {
  auto after =
      std::lower_bound(poses_.begin(), poses_.end(), t_ns, [](const Pose& pose, int64_t t) { return pose.t_ns < t; });
  if (after != poses_.end() && after->t_ns == t_ns) return after->T_robot_b;
  if (after == poses_.begin()) return std::nullopt;
  auto before = std::prev(after);
  if (after == poses_.end()) {
    if (before == poses_.begin()) return std::nullopt;
    const double interval_s = SecondsBetween(std::prev(before)->t_ns, before->t_ns);
    const double most_s = std::clamp(kIntervalsAhead * interval_s, kLeastAhead_s, kMostAhead_s);
    if (SecondsBetween(before->t_ns, t_ns) > most_s) return std::nullopt;
    after = before;
    do {
      if (before == poses_.begin()) return std::nullopt;
      --before;
    } while (SecondsBetween(before->t_ns, after->t_ns) < kLeastSpan_s);
  }
  if (SecondsBetween(before->t_ns, after->t_ns) > kLongestGap_s) return std::nullopt;
  return Between(*before, *after, t_ns);
}

}  // namespace plslam::vo
