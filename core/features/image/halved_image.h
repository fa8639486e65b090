// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cstddef>
#include <numbers>
#include <vector>

#include <opencv2/imgproc.hpp>

namespace plslam {

// Images at full, half and quarter size.

inline constexpr size_t kHalvedLevels = 3;

/// Every second pixel after a 5x5 Gaussian; empty where nothing would be left. (Means of 2x2 keep frequencies that
/// interpolation turns into bias: 0.3 pixels of a level on hard edges.)
inline cv::Mat Halved(const cv::Mat& image) {
  cv::Mat halved;
  if (std::min(image.cols, image.rows) < 2) return halved;
  cv::pyrDown(image, halved, cv::Size(image.cols / 2, image.rows / 2));
  return halved;
}

/// Of levels with pixels of `size_px` 1, 2, 4, that whose pixels are nearest to `scale` in size. There must be one.
template <class Level>
const Level& NearestLevel(const std::vector<Level>& levels, double scale) {
  size_t level = 0;
  while (level + 1 < levels.size() && scale > levels[level].size_px * std::numbers::sqrt2) ++level;
  return levels[level];
}

}  // namespace plslam
