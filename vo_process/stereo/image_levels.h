#pragma once

#include <vector>

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>

namespace plslam {

/// An image at full, half and quarter size, for comparing patches of features of different scales. Sibling of
/// `HalvedPair`.
class ImageLevels {
 public:
  struct Level {
    cv::Mat image;
    /// Size of a pixel of this level in pixels of the image: 1, 2, 4.
    double size_px = 1.0;

    // Pixel i of a halved image is centred on pixel 2i.
    Eigen::Vector2d FromImage(const Eigen::Vector2d& px) const { return px / size_px; }
    Eigen::Vector2d ToImage(const Eigen::Vector2d& px) const { return px * size_px; }
  };

  /// No image.
  ImageLevels() = default;

  /// `image` is CV_8UC1; it is shared, not copied.
  explicit ImageLevels(const cv::Mat& image);

  bool empty() const { return levels_.empty(); }

  /// The level whose pixels are nearest to `scale` in size. There must be an image.
  const Level& LevelFor(double scale) const;

 private:
  std::vector<Level> levels_;
};

}  // namespace plslam
