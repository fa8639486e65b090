#include "core/features/halved_pair.h"

#include <numbers>

#include <opencv2/imgproc.hpp>

namespace plslam {
namespace {

constexpr size_t kLevels = 3;

/// Means of 2x2 pixels, rounded; an odd last row or column is dropped.
cv::Mat Halved(const cv::Mat& image) {
  const cv::Size half(image.cols / 2, image.rows / 2);
  cv::Mat halved;
  if (half.area() == 0) return halved;
  cv::resize(image(cv::Rect(0, 0, 2 * half.width, 2 * half.height)), halved, half, 0.0, 0.0, cv::INTER_AREA);
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
