#pragma once

#include <vector>

#include <opencv2/core/mat.hpp>

namespace plslam {

/// A corner of one pyramid level at integer place.
struct Corner {
  int x = 0;
  int y = 0;
  float response = 0.0F;
};

/// FAST-9 corners of a CV_8UC1 image, local maxima of their score, at least `margin_px` (3 or more) from its border.
///
/// The image is cut into cells of about `kFastCell_px`; where none is found with `threshold`, `low_threshold` is tried,
/// so that weakly textured parts are represented. Order depends on the image only.
std::vector<Corner> DetectCorners(const cv::Mat& image, int threshold, int low_threshold, int margin_px);

inline constexpr int kFastCell_px = 32;

/// At most `quota` of the corners, spread over an image of the given size: cells take turns in giving their best, until
/// the quota is met. Ties are broken by place, so the result depends on the set of corners only.
std::vector<Corner> SpreadCorners(std::vector<Corner> corners, int quota, int width_px, int height_px);

}  // namespace plslam
