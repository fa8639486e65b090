// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "core/geometry/se3.h"

namespace plslam::vo {

/// Velocity of the camera at the time stamp of a frame, in its own frame, [m/s; rad/s]: the mean since the previous
/// frame, continued with half of its change.
class StampVelocity {
 public:
  /// Returns the velocity at the end of an interval with this mean.
  Vector6d After(const Vector6d& mean) const { return follows_ ? Vector6d(mean + 0.5 * (mean - last_)) : mean; }

  void Observe(const Vector6d& mean) {
    follows_ = true;
    last_ = mean;
  }

  /// The next interval does not continue the last one: a frame was not tracked, or the pose jumped.
  void Interrupt() { follows_ = false; }

  /// Last observed mean.
  const Vector6d& last() const { return last_; }

  /// The state between frames, for `core/files/archive.h`.
  template <class Archive, class Self>
  static void Fields(Archive& a, Self& self) {
    a(self.follows_, self.last_);
  }

 private:
  bool follows_ = false;
  Vector6d last_ = Vector6d::Zero();
};

}  // namespace plslam::vo
