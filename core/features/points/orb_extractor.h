// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <vector>

#include <opencv2/core/mat.hpp>

#include "core/features/features.h"
#include "core/features/image/image_pyramid.h"
#include "core/features/options.h"
#include "core/features/points/orb_descriptor.h"
#include "core/features/points/orb_detector.h"

namespace plslam {

/// Extracts ORB points of an image (Rublee 2011; PL-SLAM §IV.A): FAST corners on a pyramid, spread over the image,
/// oriented by the intensity centroid, steered BRIEF.
///
/// Keeps buffers between images, never results. At most `max_points`; order: by octave, then as spread.
class OrbExtractor {
 public:
  explicit OrbExtractor(const OrbOptions& options) : options_(options) {}

  /// `image` is CV_8UC1 of any size. Positions are in pixels of the image for all octaves. No points are taken where
  /// `allowed` (of the same size, or empty) is 0, so that all of them are elsewhere. `maximum` overrides the options'
  /// number of points for this image.
  std::vector<PointFeature> Extract(const cv::Mat& image, const cv::Mat& allowed = cv::Mat(),
                                    std::optional<int> maximum = std::nullopt);

 private:
  /// Returns corners of one level, at most `quota`, spread over it and localised in both directions.
  std::vector<Corner> FindCorners(int level, int quota, const cv::Mat& allowed);

  OrbOptions options_;
  ImagePyramid pyramid_;
  CornerDetector detector_;
  cv::Mat blurred_;
  std::vector<OrbDescriptor> descriptors_;
};

}  // namespace plslam
