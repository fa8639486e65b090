#include "core/features/image_pyramid.h"

#include <algorithm>
#include <cmath>

#include <opencv2/imgproc.hpp>

namespace plslam {

void ImagePyramid::Build(const cv::Mat& image, int levels, double scale_factor) {
  // Kept beyond clear(): the pixels of the last image's levels are overwritten, not allocated again.
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
    cv::resize(images_.back(), buffer, size, 0.0, 0.0, cv::INTER_LINEAR);
    images_.push_back(buffer);
    scales_.emplace_back(static_cast<double>(image.cols) / size.width, static_cast<double>(image.rows) / size.height);
  }
}

}  // namespace plslam
