// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include <opencv2/core/mat.hpp>

#include "core/features/features.h"
#include "core/features/options.h"

namespace plslam {

/// Region of a rectified image in which features may be: covered by the raw image, not masked, and far enough from the
/// border of this region that detectors do not take the border for an edge. Descriptors of coarse octaves and of lines
/// reach farther, and may include black pixels.
class FeatureMask {
 public:
  /// `seen` is CV_8UC1 of the size of the image, zero where rectification has no source or the mask excludes pixels;
  /// empty: zero nowhere.
  explicit FeatureMask(const cv::Mat& seen);

  /// Removes points that are outside, and segments with an end or the middle outside.
  void RemoveOutside(ImageFeatures& features) const;

  bool IsOutside(const Eigen::Vector2d& px) const;
  /// Whether an end or the middle is.
  bool IsOutside(const Segment2& segment) const;

  /// CV_8UC1, 0 outside the region; empty if the whole image is inside.
  const cv::Mat& inside() const { return inside_; }

 private:
  cv::Mat inside_;
};

/// Runs two independent functions, and returns when both are done: in parallel if the caller has a second thread, else
/// one after the other. The result is the same.
using RunBoth = std::function<void(const std::function<void()>&, const std::function<void()>&)>;

inline void RunInTurn(const std::function<void()>& first, const std::function<void()>& second) {
  first();
  second();
}

/// Extracts points and lines of a rectified 8-bit image (PL-SLAM §IV.A-B): ORB spread over the image, line segments by
/// the configured detector, LBD from gradients that the stages share.
///
/// Use one extractor per image stream and thread: it keeps buffers between images, never results; equal images give
/// equal features. An image without structure gives none; any size from 1x1 is accepted.
class FeatureExtractor {
 public:
  explicit FeatureExtractor(const FeatureOptions& options);
  ~FeatureExtractor();
  FeatureExtractor(FeatureExtractor&&) noexcept;
  FeatureExtractor& operator=(FeatureExtractor&&) noexcept;

  /// `run_both` may process points and lines in parallel. No points are taken where `allowed` (of the size of the
  /// image, or empty) is 0; lines are, because they may extend beyond. `max_points` overrides the options for this
  /// image.
  ImageFeatures Extract(const cv::Mat& image, const RunBoth& run_both = RunInTurn, const cv::Mat& allowed = cv::Mat(),
                        std::optional<int> max_points = std::nullopt);

  /// Extracts one feature type; none if the options exclude it. Both may run in parallel.
  std::vector<PointFeature> ExtractPoints(const cv::Mat& image, const cv::Mat& allowed = cv::Mat(),
                                          std::optional<int> max_points = std::nullopt);
  std::vector<LineFeature> ExtractLines(const cv::Mat& image);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace plslam
