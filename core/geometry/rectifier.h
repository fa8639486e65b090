// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include <opencv2/core/mat.hpp>

#include "core/geometry/bilinear_warp.h"
#include "core/geometry/rectification.h"

namespace plslam {

/// Throws std::runtime_error that names both sizes and types if the image of a `side` ("left") does not have the type
/// and the calibrated size.
void CheckImage(const cv::Mat& image, int type, const CameraCalibration& calibration, const char* side);

/// Warps the images of a rig into the rectified pair of `camera()`. Bilinear in fixed point (1/32 px), so the result is
/// the same on every machine. Pixels without a source are 0; see the masks. An already rectified pair is returned
/// unchanged and uncopied (the result shares the input's pixels).
class Rectifier {
 public:
  /// Throws std::runtime_error as `Rectify(rig)` does.
  explicit Rectifier(const RigCalibration& rig);

  const StereoCamera& camera() const { return rectification_.camera; }
  const Rectification& rectification() const { return rectification_; }
  /// Rotation from the rectified left camera (c) to the calibrated left camera (l).
  const Eigen::Quaterniond& q_l_c() const { return rectification_.q_l_c; }
  bool IsIdentity() const { return rectification_.identity; }

  /// Expects 8-bit images of the calibrated size; throws std::runtime_error that names both sizes otherwise.
  cv::Mat RectifyLeft(const cv::Mat& image) const;
  cv::Mat RectifyRight(const cv::Mat& image) const;
  /// Warps 16-bit depth aligned with the left image, by nearest neighbour, because a mean of two depths is no depth.
  /// The values do not change (z of the calibrated camera, which has the axis of the rectified one for RGB-D).
  cv::Mat RectifyDepth(const cv::Mat& depth) const;

  /// 255 for pixels of the rectified left (right) image with a source that is in use; empty if all are.
  const cv::Mat& left_mask() const { return left_.mask; }
  const cv::Mat& right_mask() const { return right_.mask; }
  /// The same, combined with `in_use` (of a raw image: 0 for masked pixels; empty: none).
  cv::Mat LeftMask(const cv::Mat& in_use) const;
  cv::Mat RightMask(const cv::Mat& in_use) const;

 private:
  struct Maps {
    std::optional<BilinearWarp> warp;
    // Coordinates of the nearest pixel, for OpenCV. Only for RGB-D.
    cv::Mat nearest;
    cv::Mat mask;
  };

  Maps MakeMaps(const RectifiedView& view, const cv::Mat& in_use, bool with_nearest) const;
  cv::Mat MaskWith(const Maps& maps, const cv::Mat& in_use) const;

  Rectification rectification_;
  Maps left_;
  Maps right_;
};

}  // namespace plslam
