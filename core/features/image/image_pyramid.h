// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cstddef>
#include <numbers>
#include <optional>
#include <vector>

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>
#include <opencv2/imgproc.hpp>

#include "core/features/image/linear_shrink.h"

namespace plslam {

// Images at full, half and quarter size.

inline constexpr size_t kHalvedLevels = 3;

/// Returns every second pixel after a 5x5 Gaussian; empty if nothing would remain. (Means of 2x2 pixels keep
/// frequencies that interpolation turns into bias: 0.3 pixels of a level on hard edges.)
inline cv::Mat Halved(const cv::Mat& image) {
  cv::Mat halved;
  if (std::min(image.cols, image.rows) < 2) return halved;
  cv::pyrDown(image, halved, cv::Size(image.cols / 2, image.rows / 2));
  return halved;
}

/// Returns the level with pixels nearest to `scale` in size, of levels with pixels of `size_px` 1, 2, 4; not empty.
template <class Level>
const Level& NearestLevel(const std::vector<Level>& levels, double scale) {
  size_t level = 0;
  while (level + 1 < levels.size() && scale > levels[level].size_px * std::numbers::sqrt2) ++level;
  return levels[level];
}

/// An image at sizes that shrink by a constant factor. Level 0 is the image itself (shared, not copied).
///
/// Levels end where an image would be smaller than `kMinSide_px`. Buffers are reused for images of equal size.
class ImagePyramid {
 public:
  static constexpr int kMinSide_px = 8;

  /// `image` is CV_8UC1 and must outlive the use of level 0.
  void Build(const cv::Mat& image, int levels, double scale_factor);

  int levels() const { return static_cast<int>(images_.size()); }
  const cv::Mat& image(int level) const { return images_[level]; }

  /// Size of a pixel of the level in pixels of the image, per axis (sizes are rounded, so not exactly powers).
  const Eigen::Vector2d& scale(int level) const { return scales_[level]; }

  /// Converts a position in a level to the image. Pixel centres are integers in both: x0 = (x + 1/2) s - 1/2.
  Eigen::Vector2d ToImage(const Eigen::Vector2d& level_px, int level) const {
    return ((level_px.array() + 0.5) * scales_[level].array() - 0.5).matrix();
  }

 private:
  void Shrink(const cv::Mat& image, cv::Size size, int level, cv::Mat& out);

  std::vector<cv::Mat> images_;
  std::vector<Eigen::Vector2d> scales_;
  // By level, for the sizes of the last image.
  std::vector<std::optional<LinearShrink>> shrinks_;
};

}  // namespace plslam
