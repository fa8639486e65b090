// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <deque>
#include <optional>

#include "core/geometry/se3.h"

namespace plslam::vo {

/// Poses of a robot by its own odometry, the last few thousand, and the motion between two times.
///
/// Poses are added in the order of time; late and repeated ones are ignored. If time goes back by a second or more, or
/// the body moved faster than robots can (its odometry was restarted), all earlier poses are dropped.
class RobotPath {
 public:
  void Add(int64_t t_ns, const SE3& T_robot_b);

  /// Whether a pose at this time or later has been added.
  bool Reaches(int64_t t_ns) const { return !poses_.empty() && poses_.back().t_ns >= t_ns; }

  /// Returns the motion of the body, T_from_to, interpolated between the poses around each time, and extrapolated for a
  /// moment beyond the newest pose. Returns nullopt if these poses are missing or too far apart, and if `to_ns` is not
  /// later than `from_ns`.
  std::optional<SE3> Motion(int64_t from_ns, int64_t to_ns) const;

 private:
  struct Pose {
    int64_t t_ns = 0;
    SE3 T_robot_b;
  };

  static bool IsJump(const Pose& before, const Pose& after);
  static SE3 Between(const Pose& a, const Pose& b, int64_t t_ns);
  std::optional<SE3> At(int64_t t_ns) const;

  std::deque<Pose> poses_;  ///< times ascend
};

}  // namespace plslam::vo
