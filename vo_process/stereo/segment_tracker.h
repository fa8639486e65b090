// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include <opencv2/core/mat.hpp>

#include "core/features/features.h"
#include "core/geometry/triangulation.h"

namespace plslam::vo {

/// Finds a known segment in an image in which it is expected within `kSegmentReach_px` pixels.
///
/// The edge is located as the detector does (`LineGrower`): in each row of a steep segment (each column of a flat one) the
/// peak of the 5x5 Sobel gradient nearest to the expected position, with sub-pixel accuracy, of the same polarity; a
/// straight line is fitted to these positions without outliers. So the errors of successive frames are as independent as
/// those of detected segments.
///
/// Returns the part of the segment that is seen, with its contrast as response; nullopt if fewer than 60 % of the positions
/// are on the line, or if the contrast differs from that of `line` by more than a factor of two.
/// `image` is that of the segment's octave; the expected segment is in pixels of the full image.
std::optional<LineFeature> LocateSegment(const cv::Mat& image, const LineFeature& line, const Segment2& expected);

inline constexpr int kSegmentReach_px = 2;

}  // namespace plslam::vo
