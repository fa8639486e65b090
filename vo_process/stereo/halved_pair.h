// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>

namespace plslam::vo {

/// Returns an image at full, half and quarter size, as far as it is large enough; the first is shared, not copied.
std::vector<cv::Mat> HalvedImages(const cv::Mat& image);

/// A rectified pair at full, half and quarter size, for comparing patches of features of different scales.
class HalvedPair {
 public:
  struct Level {
    cv::Mat left;
    cv::Mat right;
    /// Size of a pixel of this level in pixels of the images: 1, 2, 4.
    double size_px = 1.0;

    Eigen::Vector2d FromImage(const Eigen::Vector2d& px) const {
      // Pixel i of a halved image is centred on pixel 2i.
      return px / size_px;
    }
  };

  /// Both images are CV_8UC1 of one size; they are shared, not copied.
  HalvedPair(const cv::Mat& left, const cv::Mat& right);
  /// Pairs the `HalvedImages` of both.
  HalvedPair(const std::vector<cv::Mat>& left, const std::vector<cv::Mat>& right);

  const Level& full() const { return levels_.front(); }

  /// Returns the level whose pixel size is nearest to `scale`.
  const Level& LevelFor(double scale) const;

 private:
  std::vector<Level> levels_;
};

}  // namespace plslam::vo
