// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <opencv2/core/mat.hpp>

#include "core/features/features.h"

namespace plslam {

/// Where features of a rectified image may be: inside what the camera has seen and the rig does not leave out, and so
/// far from its border that detectors do not take the border for an edge. Descriptors of coarse octaves and of lines
/// reach farther, and may hold some of its black.
class FeatureMask {
 public:
  /// `seen` is CV_8UC1 of the size of the image, zero where rectification found nothing or the rig leaves something
  /// out; empty: nowhere.
  explicit FeatureMask(const cv::Mat& seen);

  /// Takes out points that are outside, and segments with an end or the middle outside.
  void RemoveOutside(ImageFeatures& features) const;

  bool IsOutside(const Eigen::Vector2d& px) const;

  /// CV_8UC1, 0 where features are outside; empty where none are.
  const cv::Mat& inside() const { return inside_; }

 private:
  cv::Mat inside_;
};

}  // namespace plslam
