// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

namespace plslam {

/// A tracked point of the rectified left image.
struct OverlayPoint {
  cv::Point2f px;
  float disparity_px = -1.0F;  ///< < 0: no depth
  int age = 0;                 ///< frames its landmark has been seen in
  bool moving = false;         ///< on a moving body
};

/// A tracked line segment of the rectified left image.
struct OverlaySegment {
  cv::Point2f p_px;
  cv::Point2f q_px;
  bool has_depth = false;
  int age = 0;
  bool moving = false;
};

struct OverlayFeatures {
  std::vector<OverlayPoint> points;
  std::vector<OverlaySegment> segments;
};

/// The image in grey with the features on it, and below it a bar with the caption and the key of the colours; 8-bit
/// BGR. Segments are thick and coloured by age, those without depth thin, grey and dashed; points are circles
/// coloured by disparity (red near, blue far; what is on a moving body is white), small ones with age 0, grey ones
/// without depth. Features with coordinates that are not finite or far outside are left out. `image` is 8-bit grey.
/// It is shaded where `mask` is 0: no features are taken there; an empty one is that of a camera that uses all.
cv::Mat DrawOverlay(const cv::Mat& image, const OverlayFeatures& features, const std::string& caption,
                    const cv::Mat& mask = cv::Mat());

}  // namespace plslam
