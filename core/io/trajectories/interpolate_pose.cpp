// SPDX-License-Identifier: BSD-3-Clause
#include "core/io/trajectories/interpolate_pose.h"

#include <algorithm>

namespace plslam {
namespace {

// Unsigned, since hostile times may be further apart than a signed number holds.
uint64_t Between(int64_t earlier_ns, int64_t later_ns) {
  return static_cast<uint64_t>(later_ns) - static_cast<uint64_t>(earlier_ns);
}

/// The one of the poses before and behind a time that is of the same moment.
std::optional<SE3> PoseOfTheMoment(const Trajectory& trajectory, Trajectory::const_iterator after, int64_t t_ns) {
  const uint64_t none = static_cast<uint64_t>(kSameMoment_ns) + 1;
  const uint64_t until = after == trajectory.end() ? none : Between(t_ns, after->t_ns);
  const uint64_t since = after == trajectory.begin() ? none : Between((after - 1)->t_ns, t_ns);
  if (std::min(until, since) >= none) return std::nullopt;
  return until < since ? after->T_a_b : (after - 1)->T_a_b;
}

}  // namespace

std::optional<SE3> InterpolatePose(const Trajectory& trajectory, int64_t t_ns, int64_t max_gap_ns) {
  const auto after = std::lower_bound(trajectory.begin(), trajectory.end(), t_ns,
                                      [](const TrajectoryPose& pose, int64_t t) { return pose.t_ns < t; });
  const bool between = after != trajectory.begin() && after != trajectory.end();
  const uint64_t gap_ns = between ? Between((after - 1)->t_ns, after->t_ns) : 0;
  if (!between || gap_ns > static_cast<uint64_t>(max_gap_ns)) return PoseOfTheMoment(trajectory, after, t_ns);
  if (after->t_ns == t_ns) return after->T_a_b;
  const TrajectoryPose& a = *(after - 1);
  const TrajectoryPose& b = *after;
  // Differences first: times as doubles are good to some 100 ns only.
  const double share = static_cast<double>(t_ns - a.t_ns) / static_cast<double>(gap_ns);
  const Eigen::Vector3d t = (1.0 - share) * a.T_a_b.translation() + share * b.T_a_b.translation();
  return SE3(a.T_a_b.rotation().slerp(share, b.T_a_b.rotation()), t);
}

}  // namespace plslam
