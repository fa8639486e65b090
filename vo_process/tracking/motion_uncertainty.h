// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include "core/geometry/se3.h"
#include "core/map/map.h"

namespace plslam::vo {

/// How uncertain a motion is, errors included that frames have in common: the covariances that are published, which a
/// filter may add up as if frames were independent. The tracker itself goes by its own, which say how well a frame
/// fits the landmarks.
///
/// The landmarks' errors (corners that slide, a calibration that is off) are the same in many frames, so they neither
/// average out nor show in residuals. What tells of them without any truth is how far adjustment moves the motions
/// between keyframes, in units of what the tracker said of them (`variance_scale`, 1 for an honest tracker). Where
/// that is about 1 or more, part of each motion's error is taken as common: that of the alignment, and a drift of 0.5
/// % of the way and 0.02 deg for each metre, which loop_process believes, too. It is counted as often as there are
/// frames in a span over which motions are added up, because common errors add up where a filter adds squares.
class MotionUncertainty {
 public:
  /// Takes the newest motions between keyframes of a session as the map has them now.
  void Learn(const Map& map, int64_t session);

  /// Of a motion whose right perturbation has this covariance, according to the tracker. A motion that was not
  /// measured, but predicted or jumped, is as uncertain as it says at least.
  Matrix6d Of(const SE3& T_prev_c, const Matrix6d& covariance, bool measured) const;

  /// Covariance to add to a motion where all lengths have a common relative error of this sigma.
  static Matrix6d OfLengths(const SE3& T_prev_c, double relative_sigma);

  /// Squares of what adjustment changes over those expected, at least 0.05, at most 25.
  double variance_scale() const { return variance_scale_; }

  /// All that it goes on with, for `core/io/files/archive.h`.
  template <class Archive, class Self>
  static void Fields(Archive& a, Self& self) {
    a(self.variance_scale_);
  }

 private:
  double CommonShare() const;

  double variance_scale_ = 1.0;
};

}  // namespace plslam::vo
