// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include <opencv2/core/mat.hpp>

#include "core/geometry/bilinear_warp.h"
#include "core/geometry/rectification.h"

namespace plslam {

/// Throws std::runtime_error that names both sizes and types where the image of a `side` ("left") is not of the type
/// and of the calibrated size.
void CheckImage(const cv::Mat& image, int type, const CameraCalibration& calibration, const char* side);

/// Warps the images of a rig into the rectified pair of `camera()`. Bilinear in fixed point (1/32 px), so the result
/// is the same on every machine. Pixels without a source are 0; `Rectification` says when there are any. A pair that
/// is rectified already passes through untouched and uncopied (the result shares the input's pixels).
class Rectifier {
 public:
  /// Throws std::runtime_error as `Rectify(rig)` does.
  explicit Rectifier(const RigCalibration& rig);

  const StereoCamera& camera() const { return rectification_.camera; }
  /// Left camera as calibrated (l) from rectified left camera (c).
  const Eigen::Quaterniond& q_l_c() const { return rectification_.q_l_c; }
  bool IsIdentity() const { return rectification_.identity; }

  /// 8-bit images of the calibrated size; anything else throws std::runtime_error that names both sizes.
  cv::Mat RectifyLeft(const cv::Mat& image) const;
  cv::Mat RectifyRight(const cv::Mat& image) const;
  /// 16-bit depth aligned with the left image, by the nearest neighbour: a mean of two depths is no depth. The values
  /// stay what they are (z of the camera as calibrated, which has the axis of the rectified one for RGB-D).
  cv::Mat RectifyDepth(const cv::Mat& depth) const;

  /// 255 where the rectified left (right) image shows something that is in use; empty when that is everywhere.
  const cv::Mat& left_mask() const { return left_.mask; }
  const cv::Mat& right_mask() const { return right_.mask; }
  /// The same where `in_use` (of an image as recorded: 0 where pixels are left out; empty: nowhere) counts as well.
  cv::Mat LeftMask(const cv::Mat& in_use) const;
  cv::Mat RightMask(const cv::Mat& in_use) const;

 private:
  struct Maps {
    std::optional<BilinearWarp> warp;
    // Coordinates of the nearest pixel, for OpenCV. Only of RGB-D.
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
