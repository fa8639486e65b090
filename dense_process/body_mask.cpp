// SPDX-License-Identifier: BSD-3-Clause
#include "dense_process/body_mask.h"

#include <opencv2/imgproc.hpp>

namespace plslam::dense {
namespace {

// Fewer features of a body are likely errors, and show little of its outline.
constexpr size_t kLeastFeatures = 6;
// Margin around the hull, as a share of the image width.
constexpr double kMargin = 0.03;

}  // namespace

cv::Mat MaskBodies(const cv::Mat& in_use, const cv::Size& size, const BodyPixels& bodies) {
  cv::Mat moving = cv::Mat::zeros(size, CV_8UC1);
  bool any = false;
  for (const auto& [body, pixels] : bodies) {
    if (pixels.size() < kLeastFeatures) continue;
    std::vector<cv::Point2f> hull;
    cv::convexHull(pixels, hull);
    std::vector<cv::Point> corners(hull.begin(), hull.end());
    cv::fillConvexPoly(moving, corners, cv::Scalar(255));
    any = true;
  }
  if (!any) return in_use;
  const int margin = static_cast<int>(kMargin * size.width);
  cv::dilate(moving, moving, cv::getStructuringElement(cv::MORPH_ELLIPSE, {2 * margin + 1, 2 * margin + 1}));
  cv::Mat rest = in_use.empty() ? cv::Mat(size, CV_8UC1, cv::Scalar(255)) : in_use.clone();
  rest.setTo(0, moving);
  return rest;
}

}  // namespace plslam::dense
