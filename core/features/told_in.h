// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "core/features/features.h"
#include "core/geometry/stereo_camera.h"

namespace plslam {

/// The steps between octaves of points, and how many octaves there are.
struct OctaveSteps {
  double scale_factor = 1.2;
  int levels = 8;
};

/// What `from` saw, as the rectified camera `to` at the same place would have seen it: rays, depths and the standard
/// deviations of both stay what they are, and points get the octave (0 .. levels - 1) that is nearest in scale. So a
/// map knows one camera only, whoever comes to it. `area` becomes the image of `from` where that is not the image of
/// `to`. Between equal cameras every bit stays.
StereoFeatures ToldIn(const StereoCamera& to, StereoFeatures features, const StereoCamera& from,
                      const OctaveSteps& octaves);

}  // namespace plslam
