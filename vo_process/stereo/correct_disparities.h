// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "core/features/features.h"
#include "vo_process/stereo/pair_skew.h"

namespace plslam {

/// Subtracts `error_px(left_px, disparity_px)` from all disparities of both feature types; those that would fall to
/// zero lose their depth.
template <class Error>
void CorrectDisparities(StereoFeatures& features, const Error& error_px) {
  const auto correct = [&error_px](const Eigen::Vector2d& left_px, double& disparity_px) {
    disparity_px -= error_px(left_px, disparity_px);
    if (disparity_px <= 0.0) disparity_px = -1.0;
  };
  for (StereoPoint& point : features.points) {
    if (point.HasDepth()) correct(point.left.px, point.disparity_px);
  }
  for (StereoLine& line : features.lines) {
    if (!line.HasDepth()) continue;
    correct(line.left.segment.p, line.disparity_p_px);
    correct(line.left.segment.q, line.disparity_q_px);
  }
}

/// From measured disparities, what the camera moved between the two images; where the pair then tells no depth, there
/// is none.
inline void TakeSkewAway(const PairSkew& skew, StereoFeatures& features) {
  if (skew.is_zero()) return;
  CorrectDisparities(features, [&skew](const Eigen::Vector2d& left_px, double disparity_px) {
    return disparity_px - skew.Disparity_px(left_px, disparity_px).value_or(0.0);
  });
}

}  // namespace plslam
