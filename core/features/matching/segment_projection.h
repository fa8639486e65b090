// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cmath>
#include <optional>

#include "core/features/features.h"
#include "core/geometry/stereo_camera.h"
#include "core/geometry/triangulation.h"

namespace plslam {

/// Returns the octave in which a corner detected in `octave` at distance `then_m` should be detected at `now_m`.
inline int ExpectedOctave(int octave, double then_m, double now_m, double scale_factor, int levels) {
  const double steps = std::log(then_m / now_m) / std::log(scale_factor);
  return std::clamp(octave + static_cast<int>(std::lround(steps)), 0, levels - 1);
}

/// Returns the part of a segment (camera frame) at least `min_depth_m` in front of the camera; nullopt if there is
/// none.
std::optional<Segment3> ClipInFront(const Segment3& segment_c, double min_depth_m);

/// Returns the part of a segment inside the image extended by `margin_px` (as in `StereoCamera::InImage`); nullopt if
/// it is shorter than a few pixels. Ends inside do not change.
std::optional<Segment2> ClipToImage(const Segment2& segment, const StereoCamera& camera, double margin_px);

/// Projects a segment (camera frame) into the left image, clipped to the image extended by `margin_px`; nullopt if less
/// than a few pixels are visible.
std::optional<Segment2> ProjectSegment(const Segment3& segment_c, const StereoCamera& camera, double margin_px);

/// Variance of the distance of a pixel from the infinite line through `observed`: `sigma_px`^2 at the observed
/// endpoints; sigma grows linearly beyond them, because the direction of a short segment is uncertain.
double VarianceAcross(const Segment2& observed, const Eigen::Vector2d& px, double sigma_px);

/// Returns the right image of an observed segment, from its disparities. It must have depth.
Segment2 RightSegment(const StereoLine& seen);

/// Returns the position s on the infinite 3D line p + s (q - p) nearest to the viewing ray of a pixel; nullopt if the
/// ray is nearly parallel to the line.
std::optional<double> AlongLine(const Segment3& segment_c, const Eigen::Vector2d& px, const StereoCamera& camera);

}  // namespace plslam
