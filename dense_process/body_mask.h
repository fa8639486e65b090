// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <vector>

#include <opencv2/core.hpp>

namespace plslam::dense {

/// Pixels of the features of each moving body in the rectified left image.
using BodyPixels = std::map<int, std::vector<cv::Point2f>>;

/// Returns `in_use` (empty: everywhere) with 0 in the convex hull of each body's features, and around it: the border of
/// a body has few features.
cv::Mat MaskBodies(const cv::Mat& in_use, const cv::Size& size, const BodyPixels& bodies);

}  // namespace plslam::dense
