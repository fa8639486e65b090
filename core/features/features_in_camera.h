// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "core/features/features.h"
#include "core/geometry/stereo_camera.h"

namespace plslam {

/// Re-expresses features of the rectified camera `from` in the rectified camera `to` at the same position: rays,
/// depths, the standard deviations of both, and octaves do not change. A map therefore needs one camera only.
/// `StereoFeatures::image` becomes the image of `from` if that differs from the image of `to`. Features of equal
/// cameras keep every bit.
StereoFeatures FeaturesInCamera(const StereoCamera& to, StereoFeatures features, const StereoCamera& from);

/// Largest ratio of the focal lengths of two cameras, and of their baselines.
inline constexpr double kMostUnlike = 100.0;
/// Whether the cameras are within that ratio, so that numbers stay in the range of messages and files.
bool AreComparable(const StereoCamera& to, const StereoCamera& from);

}  // namespace plslam
