// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include <opencv2/core/types.hpp>

#include "core/features/lines/line_detector.h"

namespace plslam {

/// Ordered by length, longest first, equal ones by place.
std::vector<DetectedSegment> LongestFirst(const std::vector<DetectedSegment>& segments);

/// Joins collinear pieces of one edge (same polarity, gap of a few pixels, within about a pixel of one straight line)
/// and drops duplicates that lie on a longer segment. The result is ordered by length, longest first.
std::vector<DetectedSegment> MergeCollinear(const std::vector<DetectedSegment>& segments);

/// The at most `max_lines` longest of `segments` (ordered longest first), spread over the image: in each cell of a
/// grid, what exceeds the cell's share counts as shorter the more longer ones the cell has already.
std::vector<DetectedSegment> SelectSpread(const std::vector<DetectedSegment>& segments, cv::Size image_size,
                                          int max_lines);

}  // namespace plslam
