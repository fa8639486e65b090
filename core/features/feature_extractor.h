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

/// Runs two pieces of work that do not touch each other's data, and returns when both are done: side by side where
/// the caller has a second thread, in turn otherwise. The result does not depend on which.
using RunBoth = std::function<void(const std::function<void()>&, const std::function<void()>&)>;

inline void RunInTurn(const std::function<void()>& first, const std::function<void()>& second) {
  first();
  second();
}

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
