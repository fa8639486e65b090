// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include <opencv2/core/mat.hpp>

#include "core/features/image/gradients.h"
#include "core/features/lines/line_detector.h"
#include "core/features/options.h"

namespace plslam {

/// Lines of an image that has few sharp ones, because the camera moved while the shutter was open or nothing sharp is
/// there. A detector made for steps of a pixel or two finds such an edge nowhere, or several times side by side,
/// wherever noise makes a peak of its slope. In halved images the slope is short again.
///
/// Keeps buffers between images, never results.
class CoarseLines {
 public:
  /// `detector` must outlive it.
  CoarseLines(LineDetector& detector, const LineOptions& options) : detector_(detector), options_(options) {}

  /// Of `segments`, those of the whole `image`, takes the soft ones out where fewer than 50 are sharp (and fewer than
  /// a quarter of `max_lines`), and adds what halved images show beside the others, with the octave of its image,
  /// longest first. Else nothing changes.
  void Complete(const cv::Mat& image, const Gradients& gradients, std::vector<DetectedSegment>& segments);

 private:
  void AddLevel(const cv::Mat& level, int octave, std::vector<DetectedSegment>& segments);

  LineDetector& detector_;
  const LineOptions& options_;
  Gradients gradients_;
};

}  // namespace plslam
