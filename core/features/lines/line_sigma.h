// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "core/features/features.h"
#include "core/features/image/gradients.h"
#include "core/geometry/triangulation.h"

namespace plslam {

inline constexpr int kMaxEdgeWidth_px = 13;

/// Returns the width of a directed segment's edge in pixels: the number of consecutive positions across, including its
/// own, at which the gradient towards the brighter side, averaged along the segment, is at least half of the largest
/// near it. 3 or 4 for a sharp edge, the length of the blur for a blurred one; `kMaxEdgeWidth_px` at most. 0 for a
/// segment without length.
int EdgeWidth_px(const Gradients& gradients, const Segment2& segment);

/// Returns the standard deviation, in pixels across the segment, of the fitted line at a position `t` along it: 0 in
/// the middle, +-1 at the endpoints, beyond them outside.
///
/// A straight line through n independent edge positions of sigma s has s / sqrt(n) in the middle and twice that at the
/// ends: s^2 / n (1 + 3 t^2). s is image noise over contrast; a floor covers errors that do not average out (edges that
/// are not straight, rectification, sampling). Constants are calibrated on rendered edges with noise. A line of a
/// halved image has half of the noise, half of the positions, and pixels of twice the size.
double LineSigma_px(double length_px, double contrast, double t, int octave = 0);

/// The same at the ends, including the error of blurred edges, whose two sides need not be blurred alike.
double EndSigma_px(const LineFeature& line);

/// Returns the position of `point` along the segment in the unit of `LineSigma_px`.
double PlaceAlong(const Segment2& segment, const Eigen::Vector2d& point);

}  // namespace plslam
