// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include "core/geometry/se3.h"
#include "core/ids/ids.h"
#include "core/map/map.h"

namespace plslam::vo {

/// Uncertainty of motions including errors that frames have in common: the published covariances, which a filter may
/// add up as if frames were independent. The tracker itself uses its own covariances, which describe how well a frame
/// fits the landmarks.
///
/// Errors of landmarks (sliding corners, an inaccurate calibration) are the same in many frames, so they neither
/// average out nor show in residuals. They show without ground truth in the changes of motions between keyframes by
/// adjustment, relative to the tracker's covariances (`variance_scale`, 1 for a consistent tracker). If that is about 1
/// or more, part of each motion's error counts as common: that of the alignment, and a drift of 0.5 % of the path and
/// 0.02 deg for each metre, as in loop_process. The common part is multiplied by the number of frames over which
/// motions are composed, because common errors add linearly where a filter adds squares.
class MotionUncertainty {
 public:
  /// Updates `variance_scale` from the newest motions between keyframes of a session in the map.
  void Learn(const Map& map, SessionId session);

  /// Returns the published covariance of a motion, given the tracker's covariance of its right perturbation. A motion
  /// that was not measured, but predicted or a jump, keeps at least its covariance.
  Matrix6d Of(const SE3& T_prev_c, const Matrix6d& covariance, bool measured) const;

  /// Returns the covariance to add to a motion if all lengths have a common relative error of this sigma.
  static Matrix6d OfLengths(const SE3& T_prev_c, double relative_sigma);

  /// Squared changes by adjustment over their expectation, at least 0.05, at most 25.
  double variance_scale() const { return variance_scale_; }

  /// The state between frames, for `core/files/archive.h`.
  template <class Archive, class Self>
  static void Fields(Archive& a, Self& self) {
    a(self.variance_scale_);
  }

 private:
  double CommonShare() const;

  double variance_scale_ = 1.0;
};

}  // namespace plslam::vo
