// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include <opencv2/core/mat.hpp>

#include "core/geometry/bilinear_warp.h"
#include "core/geometry/rectification.h"

namespace plslam::viewer {

/// The image at most `width_px` wide. Means of whole blocks as far as they go (a border narrower than a block is cut
/// off), and the rest between pixels: a tenth of the time that means over parts of pixels take.
cv::Mat Shrink(const cv::Mat& image, int width_px);

/// Rectifies images of one camera as `Rectifier` does, and reduces them for display. It warps at the reduced size: a
/// third of the time and memory of a full rectified image.
class SmallRectifier {
 public:
  /// `view` is the view of `rectification` for these images, `side` its name in errors.
  SmallRectifier(const Rectification& rectification, const RectifiedView& view, const char* side, int width_px);

  /// `image` as recorded, 8-bit grey, becomes one at most `width_px` wide. Throws the exceptions of `CheckImage`.
  cv::Mat Apply(const cv::Mat& image) const;

 private:
  CameraCalibration calibration_;
  const char* side_;
  int width_px_;
  int block_;
  std::optional<BilinearWarp> warp_;  // of the means of blocks; empty if images are rectified already
};

}  // namespace plslam::viewer
