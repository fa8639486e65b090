// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>

#include <vector>

namespace plslam {

/// Returns how well a 7x7 patch is localised in both directions: ratio of the smaller to the larger eigenvalue of its
/// summed gradient products, 0 for a straight edge, 1 for an isotropic patch (Harris & Stephens 1988; the ratio is
/// independent of contrast). A corner caused by noise on an edge slides along it, and its position is meaningless.
///
/// Gradients are central differences; (x, y) must be at least 4 pixels from the border of the CV_8UC1 image.
double CornerRatio(const cv::Mat& image, int x, int y);

/// A corner of one pyramid level at an integer position; `response` is its FAST score.
struct Corner {
  int x = 0;
  int y = 0;
  int response = 0;
};

/// FAST-9 corners, spread over images. Keeps buffers between images, never results.
class CornerDetector {
 public:
  /// Returns corners of a CV_8UC1 image with a score above `threshold`, local maxima, at least `margin_px` from its
  /// border, in reading order. In cells (about 32 pixels wide) without any, those above `low_threshold`, so that weakly
  /// textured regions are represented.
  std::vector<Corner> Detect(const cv::Mat& image, int threshold, int low_threshold, int margin_px);

  /// Sub-pixel position of a corner of the last image: vertex of parabolas through its score and its neighbours'.
  Eigen::Vector2d SubPixel(const Corner& corner) const;

 private:
  cv::Mat scores_;
  cv::Mat maxima_;
};

/// Returns at most `quota` of the corners, spread over an image of the given size: cells take turns in giving their
/// best, until the quota is met. Ties are broken by position, so the result depends on the set of corners only.
std::vector<Corner> SpreadCorners(const std::vector<Corner>& corners, int quota, int width_px, int height_px);

}  // namespace plslam
