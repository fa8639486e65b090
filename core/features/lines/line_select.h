// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include <opencv2/core/types.hpp>

#include "core/features/lines/line_detector.h"

namespace plslam {

/// Sorts by length, longest first, equal ones by position.
std::vector<DetectedSegment> LongestFirst(const std::vector<DetectedSegment>& segments);

/// Joins collinear pieces of one edge (same polarity, gap of a few pixels, within about a pixel of one straight line)
/// and removes duplicates of a longer segment. The result is sorted by length, longest first.
std::vector<DetectedSegment> MergeCollinear(const std::vector<DetectedSegment>& segments);

/// Returns at most `max_lines` of `segments` (sorted longest first), spread over the image: segments above a grid
/// cell's share count as shorter, the more so the more longer ones the cell has.
std::vector<DetectedSegment> SelectSpread(const std::vector<DetectedSegment>& segments, cv::Size image_size,
                                          int max_lines);

}  // namespace plslam
