// SPDX-License-Identifier: BSD-3-Clause
#include "core/features/feature_mask.h"

#include <cmath>

#include <opencv2/imgproc.hpp>

namespace plslam {
namespace {

// Corners and edges are detected by what lies this near.
constexpr int kMaskMargin_px = 8;

}  // namespace

FeatureMask::FeatureMask(const cv::Mat& seen) {
  if (seen.empty()) return;
  const int size = 2 * kMaskMargin_px + 1;
  cv::erode(seen, inside_, cv::Mat::ones(size, size, CV_8U), cv::Point(-1, -1), 1, cv::BORDER_CONSTANT,
            cv::Scalar(255));
}

bool FeatureMask::IsOutside(const Eigen::Vector2d& px) const {
  if (inside_.empty()) return false;
  const int u = static_cast<int>(std::lround(px.x()));
  const int v = static_cast<int>(std::lround(px.y()));
  return u < 0 || v < 0 || u >= inside_.cols || v >= inside_.rows || inside_.at<uchar>(v, u) == 0;
}

void FeatureMask::RemoveOutside(ImageFeatures& features) const {
  if (inside_.empty()) return;
  std::erase_if(features.points, [this](const PointFeature& point) { return IsOutside(point.px); });
  std::erase_if(features.lines, [this](const LineFeature& line) {
    const Eigen::Vector2d middle = 0.5 * (line.segment.p + line.segment.q);
    return IsOutside(line.segment.p) || IsOutside(line.segment.q) || IsOutside(middle);
  });
}

}  // namespace plslam
