// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <deque>
#include <optional>

#include "core/geometry/se3.h"

namespace plslam::vo {

/// Where a robot was by its own odometry, over the last thousands of poses that it told, and how it moved between two
/// times.
///
/// Poses are taken in the order of their times: one that is a little late, or comes again, is passed over. Where time
/// goes back by a second or more, or the body would have to be faster than robots are (its odometry has begun anew),
/// only what comes from then on counts.
class RobotPath {
 public:
  void Add(int64_t t_ns, const SE3& T_robot_b);

  /// A pose of that time or a later one has come.
  bool Reaches(int64_t t_ns) const { return !poses_.empty() && poses_.back().t_ns >= t_ns; }

  /// Motion of the body, T_from_to, interpolated between the poses around each time, and for a moment beyond the newest
  /// pose with the motion of the last ones. nullopt where these poses are not there or are too far apart, and where
  /// `to_ns` is not later than `from_ns`.
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
