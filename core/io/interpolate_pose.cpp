#include "core/io/interpolate_pose.h"

#include <algorithm>

namespace plslam {

std::optional<SE3> InterpolatePose(const Trajectory& trajectory, int64_t t_ns, int64_t max_gap_ns) {
  const auto after = std::lower_bound(trajectory.begin(), trajectory.end(), t_ns,
                                      [](const TrajectoryPose& pose, int64_t t) { return pose.t_ns < t; });
  if (after == trajectory.end()) return std::nullopt;
  if (after->t_ns == t_ns) return after->T_a_b;
  if (after == trajectory.begin()) return std::nullopt;
  const TrajectoryPose& a = *(after - 1);
  const TrajectoryPose& b = *after;
  // Differences first: times as doubles are good to some 100 ns only. Unsigned, since hostile times may be further apart
  // than a signed number holds.
  const uint64_t gap_ns = static_cast<uint64_t>(b.t_ns) - static_cast<uint64_t>(a.t_ns);
  if (gap_ns > static_cast<uint64_t>(max_gap_ns)) return std::nullopt;
  const double share = static_cast<double>(t_ns - a.t_ns) / static_cast<double>(gap_ns);
  const Eigen::Vector3d t = (1.0 - share) * a.T_a_b.translation() + share * b.T_a_b.translation();
  return SE3(a.T_a_b.rotation().slerp(share, b.T_a_b.rotation()), t);
}

}  // namespace plslam
