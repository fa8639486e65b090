// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include <opencv2/core/mat.hpp>

#include "core/features/image/gradients.h"
#include "core/features/lines/line_detector.h"
#include "core/features/options.h"

namespace plslam {

/// Finds lines of an image that has few sharp ones, because of motion blur or lack of sharp edges. A detector for steps
/// of a pixel or two misses such an edge, or finds it several times side by side, at peaks of noise on its slope. In
/// halved images the slope is short again.
///
/// Keeps buffers between images, never results.
class CoarseLines {
 public:
  /// `detector` must outlive it.
  CoarseLines(LineDetector& detector, const LineOptions& options) : detector_(detector), options_(options) {}

  /// If fewer than 50 of `segments` of the whole `image` are sharp (and fewer than a quarter of `max_lines`), removes
  /// the others, and adds segments of halved images that are not near existing ones, with the octave of their image.
  /// Sorts the result by length, longest first. Otherwise changes nothing.
  void Complete(const cv::Mat& image, const Gradients& gradients, std::vector<DetectedSegment>& segments);

 private:
  void AddLevel(const cv::Mat& level, int octave, std::vector<DetectedSegment>& segments);

  LineDetector& detector_;
  const LineOptions& options_;
  Gradients gradients_;
};

}  // namespace plslam
