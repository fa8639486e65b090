// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "core/features/features.h"
#include "core/geometry/stereo_camera.h"

namespace plslam {

/// What `from` saw, as the rectified camera `to` at the same place would have seen it: rays, depths and the standard
/// deviations of both stay what they are, and so do octaves. A map therefore needs one camera only.
/// `StereoFeatures::image` becomes the image of `from` where that is not the image of `to`. Between equal cameras every
/// bit stays.
StereoFeatures ToldIn(const StereoCamera& to, StereoFeatures features, const StereoCamera& from);

/// Largest ratio of the focal lengths of two cameras, and of their baselines.
inline constexpr double kMostUnlike = 100.0;
/// Whether they are as alike as that: numbers then stay within what messages and files hold.
bool CanBeToldIn(const StereoCamera& to, const StereoCamera& from);

}  // namespace plslam
