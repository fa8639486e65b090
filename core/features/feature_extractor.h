// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include <opencv2/core/mat.hpp>

#include "core/features/features.h"
#include "core/features/image/run_both.h"
#include "core/features/options.h"

namespace plslam {

/// Points and lines of one rectified 8-bit image (PL-SLAM §IV.A-B): ORB spread over the image, line segments by the
/// chosen detector, LBD computed from gradients that the stages share.
///
/// One extractor per image stream and thread: it keeps buffers between images, never results; equal images give
/// equal features. An image without structure gives none; any size from 1x1 is accepted.
class FeatureExtractor {
 public:
  explicit FeatureExtractor(const FeatureOptions& options);
  ~FeatureExtractor();
  FeatureExtractor(FeatureExtractor&&) noexcept;
  FeatureExtractor& operator=(FeatureExtractor&&) noexcept;

  /// `run_both` may do points and lines at the same time. Where `allowed` (of the size of the image, or empty) is 0
  /// no points are taken; lines are, as they may reach out of there. `max_points` is for this image, instead of that
  /// of the options.
  ImageFeatures Extract(const cv::Mat& image, const RunBoth& run_both = RunInTurn, const cv::Mat& allowed = cv::Mat(),
                        std::optional<int> max_points = std::nullopt);

  /// One of the two alone; none where the options leave it out. Points and lines may be extracted at the same time.
  std::vector<PointFeature> ExtractPoints(const cv::Mat& image, const cv::Mat& allowed = cv::Mat(),
                                          std::optional<int> max_points = std::nullopt);
  std::vector<LineFeature> ExtractLines(const cv::Mat& image);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace plslam
