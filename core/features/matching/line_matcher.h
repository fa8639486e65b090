// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "core/features/features.h"
#include "core/features/options.h"

namespace plslam {

/// Predicted line in the image, and its last descriptor.
struct PredictedLine {
  Segment2 segment;
  Descriptor descriptor{};
};

/// Returns for each prediction the index of its matching feature, or -1 (PL-SLAM §IV.B; gates in LineMatchOptions).
///
/// A candidate has nearly the predicted direction (directed, so the polarity of the edge agrees), is within the window
/// across the predicted line, overlaps it along the line, and has a similar descriptor; lengths are compared loosely,
/// because detectors cut the same edge differently in each view. Matches are mutual best and clearly better than the
/// second candidate, unless that is a piece of the same edge. Each feature is matched at most once. Predictions that
/// are not finite, or shorter than a pixel, get -1.
std::vector<int> MatchLinesByProjection(const std::vector<PredictedLine>& predicted,
                                        const std::vector<LineFeature>& features, const LineMatchOptions& options);
std::vector<int> MatchLinesByProjection(const std::vector<PredictedLine>& predicted,
                                        const std::vector<StereoLine>& features, const LineMatchOptions& options);

/// Matches by descriptors alone, for recovery: for each line of `a` the index of its mutual best in `b`, or -1. Gates
/// on descriptor distance and ratio only.
std::vector<int> MatchLinesBruteForce(const std::vector<LineFeature>& a, const std::vector<LineFeature>& b,
                                      const LineMatchOptions& options);
std::vector<int> MatchLinesBruteForce(const std::vector<Descriptor>& a, const std::vector<Descriptor>& b,
                                      const LineMatchOptions& options);

}  // namespace plslam
