#pragma once

#include "core/map/keyframe.h"
#include "core/optim/bundle/bundle.h"

namespace plslam {

/// What a feature of keyframe `pose` measures of point `point`; both are places in the vectors of a `BundleProblem`.
inline PointSight SightOf(int pose, int point, const StereoPoint& seen) {
  return {
      pose, point, {seen.left.px.x(), seen.left.px.y(), seen.disparity_px}, seen.sigma_px, seen.sigma_disparity_px};
}

/// Sibling for lines.
inline LineSight SightOf(int pose, int line, const StereoLine& seen) {
  return {pose,
          line,
          seen.left.segment,
          seen.disparity_p_px,
          seen.disparity_q_px,
          seen.sigma_px,
          seen.sigma_disparity_p_px,
          seen.sigma_disparity_q_px};
}

}  // namespace plslam
