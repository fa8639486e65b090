// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "core/features/features.h"
#include "core/features/image/gradients.h"
#include "core/geometry/triangulation.h"

namespace plslam {

inline constexpr int kMaxEdgeWidth_px = 13;

/// Over how many pixels across a directed segment its edge rises: places side by side, the segment's own among them,
/// whose gradient towards the brighter side, in the mean along the segment, is at least half of the largest near it.
/// A sharp edge has 3 or 4, one that motion has blurred as many as the blur is long; `kMaxEdgeWidth_px` at most. 0
/// for a segment without length.
int EdgeWidth_px(const Gradients& gradients, const Segment2& segment);

/// Standard deviation, in pixels across the segment, of the line fitted through it, at a place `t` along it: 0 in the
/// middle, +-1 at the endpoints, beyond them outside.
///
/// A straight line through n independent edge places of sigma s has s / sqrt(n) in the middle and twice that at
/// the ends: s^2 / n (1 + 3 t^2). s is image noise over contrast; a floor stands for what does not average out (edges
/// that are not quite straight, rectification, sampling). Constants calibrated on rendered edges with noise. A line
/// of a halved image has half of the noise, half of the places, and pixels of twice the size.
double LineSigma_px(double length_px, double contrast, double t, int octave = 0);

/// The same at its ends, with what a blurred edge errs beyond its fit: its two sides need not be blurred alike.
double EndSigma_px(const LineFeature& line);

/// Place of `point` along the segment in the unit of `LineSigma_px`.
double PlaceAlong(const Segment2& segment, const Eigen::Vector2d& point);

}  // namespace plslam
