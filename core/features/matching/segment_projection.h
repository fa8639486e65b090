// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cmath>
#include <optional>

#include "core/features/features.h"
#include "core/geometry/stereo_camera.h"
#include "core/geometry/triangulation.h"

namespace plslam {

/// Octave in which a corner that was found in `octave` from `then_m` away should be found from `now_m` away.
inline int ExpectedOctave(int octave, double then_m, double now_m, double scale_factor, int levels) {
  const double steps = std::log(then_m / now_m) / std::log(scale_factor);
  return std::clamp(octave + static_cast<int>(std::lround(steps)), 0, levels - 1);
}

/// The part of a segment (camera frame) at least `min_depth_m` in front of the camera; nullopt where there is none.
std::optional<Segment3> ClipInFront(const Segment3& segment_c, double min_depth_m);

/// The part of a segment inside the image grown by `margin_px` (as `StereoCamera::InImage` has it); nullopt where
/// less than a few pixels are. Ends inside stay as they are.
std::optional<Segment2> ClipToImage(const Segment2& segment, const StereoCamera& camera, double margin_px);

/// A segment (camera frame) as it should appear in the left image, cut to the image grown by `margin_px`; nullopt
/// where less than a few pixels would be seen.
std::optional<Segment2> ProjectSegment(const Segment3& segment_c, const StereoCamera& camera, double margin_px);

/// Distance of a pixel to the infinite line through `observed`, as a variance: `sigma_px` at the observed endpoints,
/// growing linearly beyond them, since the direction of a short segment is less sure than its place.
double VarianceAcross(const Segment2& observed, const Eigen::Vector2d& px, double sigma_px);

/// Right image of an observed segment, from its disparities. It must have depth.
Segment2 RightSegment(const StereoLine& seen);

/// Place along the infinite 3D line p + s (q - p) that is nearest to the viewing ray of a pixel; nullopt where the
/// ray is nearly parallel to the line.
std::optional<double> AlongLine(const Segment3& segment_c, const Eigen::Vector2d& px, const StereoCamera& camera);

}  // namespace plslam
