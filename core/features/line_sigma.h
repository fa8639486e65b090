#pragma once

#include "core/geometry/segment.h"

namespace plslam {

/// Standard deviation, in pixels across the segment, of the line fitted through it, at a place `t` along it: 0 in the
/// middle, +-1 at the endpoints, beyond them outside.
///
/// A straight line through n independent edge places of deviation s has s / sqrt(n) in the middle and twice that at
/// the ends: s^2 / n (1 + 3 t^2). s is image noise over contrast; a floor stands for what does not average out
/// (edges that are not quite straight, rectification, sampling). Constants calibrated on rendered edges with noise.
double LineSigma_px(double length_px, double contrast, double t);

/// Place of `point` along the segment in the unit of `LineSigma_px`.
double PlaceAlong(const Segment2& segment, const Eigen::Vector2d& point);

}  // namespace plslam
