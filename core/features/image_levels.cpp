#include "core/features/image_levels.h"

#include <algorithm>
#include <numbers>

#include <opencv2/imgproc.hpp>

namespace plslam {
namespace {

constexpr size_t kLevels = 3;

cv::Mat Halved(const cv::Mat& image) {
  cv::Mat halved;
  if (std::min(image.cols, image.rows) < 2) return halved;
  cv::pyrDown(image, halved, cv::Size(image.cols / 2, image.rows / 2));
  return halved;
}

}  // namespace

ImageLevels::ImageLevels(const cv::Mat& image) {
  if (image.empty()) return;
  levels_.push_back({image, 1.0});
  while (levels_.size() < kLevels) {
    const Level& last = levels_.back();
    Level next{Halved(last.image), 2.0 * last.size_px};
    if (next.image.empty()) break;
    levels_.push_back(next);
  }
}

const ImageLevels::Level& ImageLevels::LevelFor(double scale) const {
  size_t level = 0;
  while (level + 1 < levels_.size() && scale > levels_[level].size_px * std::numbers::sqrt2) ++level;
  return levels_[level];
}

}  // namespace plslam
