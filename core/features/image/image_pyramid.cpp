// SPDX-License-Identifier: BSD-3-Clause
#include "core/features/image/image_pyramid.h"

#include <algorithm>
#include <cmath>

#include <opencv2/imgproc.hpp>

namespace plslam {

void ImagePyramid::Build(const cv::Mat& image, int levels, double scale_factor) {
  // Buffers of the last image's levels are overwritten, not allocated again.
  std::vector<cv::Mat> buffers = std::move(images_);
  images_.assign(1, image);
  scales_.assign(1, Eigen::Vector2d::Ones());
  double scale = 1.0;
  for (int level = 1; level < levels; ++level) {
    scale *= scale_factor;
    const cv::Size size(static_cast<int>(std::lround(image.cols / scale)),
                        static_cast<int>(std::lround(image.rows / scale)));
    if (std::min(size.width, size.height) < kMinSide_px) break;
    cv::Mat buffer = level < static_cast<int>(buffers.size()) ? buffers[level] : cv::Mat();
    Shrink(images_.back(), size, level, buffer);
    images_.push_back(buffer);
    scales_.emplace_back(static_cast<double>(image.cols) / size.width, static_cast<double>(image.rows) / size.height);
  }
}

void ImagePyramid::Shrink(const cv::Mat& image, cv::Size size, int level, cv::Mat& out) {
  if (!LinearShrink::Fits(image.size(), size)) {
    cv::resize(image, out, size, 0.0, 0.0, cv::INTER_LINEAR);
    return;
  }
  shrinks_.resize(std::max(shrinks_.size(), static_cast<size_t>(level) + 1));
  std::optional<LinearShrink>& shrink = shrinks_[static_cast<size_t>(level)];
  if (!shrink || shrink->from() != image.size() || shrink->to() != size) shrink.emplace(image.size(), size);
  shrink->Apply(image, out);
}

}  // namespace plslam
