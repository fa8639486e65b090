#pragma once

#include "core/features/features.h"

namespace plslam {

/// Where disparities of lines come from.
enum class LineDisparities {
  kRightLine,  ///< where the right line crosses the row
  kDepthMap,   ///< depths along the left line
};

/// Adds to the deviations of lines what their fit cannot know: edges that are not straight, that lie on round objects,
/// or that two detections cut from neighbouring edges. `sigma_px` is across the segment, in either image. Where a depth map tells
/// the disparities, they have no part in it.
void AddLineModelError(double sigma_px, LineDisparities disparities, StereoFeatures& features);

}  // namespace plslam
