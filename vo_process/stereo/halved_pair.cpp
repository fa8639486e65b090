// SPDX-License-Identifier: BSD-3-Clause
#include "vo_process/stereo/halved_pair.h"

#include <algorithm>

#include "core/features/image/image_pyramid.h"

namespace plslam::vo {

std::vector<cv::Mat> HalvedImages(const cv::Mat& image) {
  std::vector<cv::Mat> levels{image};
  while (levels.size() < kHalvedLevels) {
    cv::Mat next = Halved(levels.back());
    if (next.empty()) break;
    levels.push_back(next);
  }
  return levels;
}

HalvedPair::HalvedPair(const cv::Mat& left, const cv::Mat& right)
    : HalvedPair(HalvedImages(left), HalvedImages(right)) {}

HalvedPair::HalvedPair(const std::vector<cv::Mat>& left, const std::vector<cv::Mat>& right) {
  double size_px = 1.0;
  for (size_t i = 0; i < std::min(left.size(), right.size()); ++i, size_px *= 2.0) {
    levels_.push_back({left[i], right[i], size_px});
  }
}

const HalvedPair::Level& HalvedPair::LevelFor(double scale) const { return NearestLevel(levels_, scale); }

}  // namespace plslam::vo
