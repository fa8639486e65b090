#pragma once

#include "core/features/features.h"

namespace plslam {

/// Adds to the deviations of lines what their fit cannot know: edges that are not straight, that lie on round objects,
/// or that two detections cut from neighbouring edges. `sigma_px` is across the segment, in either image.
void AddLineModelError(double sigma_px, StereoFeatures& features);

}  // namespace plslam
