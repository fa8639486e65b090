// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "vo_process/tracking/tracked_frame.h"

namespace plslam::vo {

/// How many corners are looked for in the images of the next pair.
///
/// The strongest corners are taken, and where it snows the strongest are snow: streaks that are elsewhere in the
/// other image and in the next one. So where few of the strongest corners have a depth or were seen before, so many
/// more are looked for that there should be as many of use as usual, until most of the strongest are of use again.
class CornerBudget {
 public:
  /// `usual` corners in an image where all is well.
  explicit CornerBudget(int usual) : usual_(usual) {}

  int max_points() const { return factor_ > 1.0 ? static_cast<int>(factor_ * usual_) : usual_; }

  /// Learns from a frame that has been tracked, or was tried to be.
  void Observe(const TrackedFrame& frame);

  /// All that it goes on with, for `core/io/files/archive.h`.
  template <class Archive, class Self>
  static void Fields(Archive& a, Self& self) {
    a(self.factor_);
  }

 private:
  int usual_;
  double factor_ = 1.0;
};

}  // namespace plslam::vo
