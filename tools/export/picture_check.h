// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <opencv2/core/mat.hpp>

#include "core/features/features.h"

namespace plslam::exports {

/// Whether `image`, 8-bit grey and rectified, is the one in which a keyframe's features were detected: points of it are
/// found there again, with similar descriptors. Times are not enough: many datasets begin at 0. A keyframe with too few
/// points for a decision is not recognised.
bool ShowsKeyframe(const cv::Mat& image, const FeaturesView& features);

}  // namespace plslam::exports
