#include "core/features/halved_pair.h"

#include <algorithm>
#include <numbers>

#include <opencv2/imgproc.hpp>

namespace plslam {
namespace {

constexpr size_t kLevels = 3;

/// Every second pixel after a 5x5 Gaussian. (Means of 2x2 keep frequencies that interpolation turns into bias: 0.3 pixels
/// of a level on hard edges.)
cv::Mat Halved(const cv::Mat& image) {
  cv::Mat halved;
  if (std::min(image.cols, image.rows) < 2) return halved;
  cv::pyrDown(image, halved, cv::Size(image.cols / 2, image.rows / 2));
  return halved;
}

}  // namespace

HalvedPair::HalvedPair(const cv::Mat& left, const cv::Mat& right) {
  levels_.push_back({left, right, 1.0});
  while (levels_.size() < kLevels) {
    const Level& last = levels_.back();
    Level next{Halved(last.left), Halved(last.right), 2.0 * last.size_px};
    if (next.left.empty() || next.right.empty()) break;
    levels_.push_back(next);
  }
}

const HalvedPair::Level& HalvedPair::LevelFor(double scale) const {
  size_t level = 0;
  while (level + 1 < levels_.size() && scale > levels_[level].size_px * std::numbers::sqrt2) ++level;
  return levels_[level];
}

}  // namespace plslam
