// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "core/features/features.h"
#include "core/features/options.h"

namespace plslam {

/// Where a known line should appear in the image, and how it looked when last seen.
struct PredictedLine {
  Segment2 segment;
  Descriptor descriptor{};
};

/// For each prediction the index of the feature that continues it, or -1 (PL-SLAM §IV.B; gates in LineMatchOptions).
///
/// A candidate runs in nearly the predicted direction (directed, so the polarity of the edge agrees), lies within the
/// window across the predicted line, overlaps it along the line, and has a similar descriptor; lengths are compared
/// loosely, since detectors cut the same edge differently in every view. Matches are best from both sides and, where
/// a second candidate is not a piece of the same edge, clearly better than it. Each feature is given at most once.
/// Predictions that are not finite, or shorter than a pixel, get -1.
std::vector<int> MatchLinesByProjection(const std::vector<PredictedLine>& predicted,
                                        const std::vector<LineFeature>& features, const LineMatchOptions& options);
std::vector<int> MatchLinesByProjection(const std::vector<PredictedLine>& predicted,
                                        const std::vector<StereoLine>& features, const LineMatchOptions& options);

/// By descriptors alone, for recovery: for each line of `a` the index of its mutual best in `b`, or -1. Gates on
/// descriptor distance and ratio only.
std::vector<int> MatchLinesBruteForce(const std::vector<LineFeature>& a, const std::vector<LineFeature>& b,
                                      const LineMatchOptions& options);
std::vector<int> MatchLinesBruteForce(const std::vector<Descriptor>& a, const std::vector<Descriptor>& b,
                                      const LineMatchOptions& options);

}  // namespace plslam
