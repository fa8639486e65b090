// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "core/features/features.h"
#include "core/geometry/stereo_camera.h"

namespace plslam {

/// What `from` saw, as the rectified camera `to` at the same place would have seen it: rays, depths and the standard
/// deviations of both stay what they are, and so do octaves. So a map knows one camera only, whoever comes to it.
/// `StereoFeatures::image` becomes the image of `from` where that is not the image of `to`. Between equal cameras every
/// bit stays.
StereoFeatures ToldIn(const StereoCamera& to, StereoFeatures features, const StereoCamera& from);

/// Whether numbers stay within what messages and files hold: focal lengths and baselines at most this many times those
/// of the other.
inline constexpr double kMostUnlike = 100.0;
bool CanBeToldIn(const StereoCamera& to, const StereoCamera& from);

}  // namespace plslam
