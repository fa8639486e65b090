// SPDX-License-Identifier: BSD-3-Clause
#include "tools/refine/followed_frames.h"

#include <iterator>

namespace plslam::refine {

Trajectory FollowKeyframes(const Trajectory& frames, const Displacements& by_time) {
  if (by_time.empty()) return frames;
  Trajectory moved;
  moved.reserve(frames.size());
  for (const TrajectoryPose& frame : frames) {
    const auto after = by_time.lower_bound(frame.t_ns);
    if (after == by_time.end() || after == by_time.begin() || after->first == frame.t_ns) {
      const SE3& T = after == by_time.end() ? by_time.rbegin()->second : after->second;
      moved.push_back({frame.t_ns, T * frame.T_a_b});
      continue;
    }
    const auto before = std::prev(after);
    const double share =
        static_cast<double>(frame.t_ns - before->first) / static_cast<double>(after->first - before->first);
    const SE3 with_before = before->second * frame.T_a_b;
    const SE3 with_after = after->second * frame.T_a_b;
    const Vector6d step = (with_before.Inverse() * with_after).Log();
    moved.push_back({frame.t_ns, with_before * SE3::Exp(share * step)});
  }
  return moved;
}

}  // namespace plslam::refine
