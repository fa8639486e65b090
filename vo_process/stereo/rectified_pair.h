// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include <opencv2/core/mat.hpp>

namespace plslam::vo {

/// The `HalvedImages` of a rectified pair; for RGB-D rigs a depth map instead of the right ones.
struct RectifiedPair {
  std::vector<cv::Mat> left;
  std::vector<cv::Mat> right;
  cv::Mat depth;

  bool HasDepthMap() const { return right.empty(); }
};

}  // namespace plslam::vo
