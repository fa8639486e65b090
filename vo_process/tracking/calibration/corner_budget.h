// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "vo_process/tracking/landmarks/tracked_frame.h"

namespace plslam::vo {

/// Number of corners to detect in the images of the next pair.
///
/// Detection keeps the strongest corners, and in falling snow these are streaks, which are elsewhere in the other image
/// and in the next one. If few of the strongest corners have a depth or were tracked, the budget grows so that the
/// usual number of useful ones is expected, until most of the strongest are useful again.
class CornerBudget {
 public:
  /// `usual`: number of corners under normal conditions.
  explicit CornerBudget(int usual) : usual_(usual) {}

  int max_points() const { return factor_ > 1.0 ? static_cast<int>(factor_ * usual_) : usual_; }

  /// Updates the budget after a frame, tracked or lost.
  void Observe(const TrackedFrame& frame);

  /// The state between frames, for `core/files/archive.h`.
  template <class Archive, class Self>
  static void Fields(Archive& a, Self& self) {
    a(self.factor_);
  }

 private:
  int usual_;
  double factor_ = 1.0;
};

}  // namespace plslam::vo
