// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <opencv2/core/mat.hpp>

#include <memory>
#include <string>
#include <vector>

#include "core/features/image/gradients.h"
#include "core/features/options.h"
#include "core/geometry/triangulation.h"

namespace plslam {

/// A segment as detected.
struct DetectedSegment {
  Segment2 segment;
  /// Mean contrast across the segment, grey levels; positive: the brighter side is on the right of p->q.
  double contrast = 0.0;
  /// Of the image that it was found in: halved so many times.
  int octave = 0;
};

/// One way to find straight edges in an image (PL-SLAM §IV.B). Implementations keep buffers, never results.
class LineDetector {
 public:
  virtual ~LineDetector() = default;

  /// Directed segments, unordered, possibly in pieces and of any length; `gradients` are those of `image` (CV_8UC1,
  /// any size).
  virtual std::vector<DetectedSegment> Detect(const cv::Mat& image, const Gradients& gradients) = 0;
};

/// The detector named by `options.detector`. Throws std::invalid_argument for an unknown name.
std::unique_ptr<LineDetector> MakeLineDetector(const LineOptions& options);

/// The two detectors by themselves.
std::unique_ptr<LineDetector> MakeEdgeChainDetector(const LineOptions& options);
std::unique_ptr<LineDetector> MakeLsdDetector(const LineOptions& options);

/// The segment turned so that its brighter side is on the right, with the contrast that the gradients show across it.
DetectedSegment Direct(const Segment2& segment, const Gradients& gradients);

}  // namespace plslam
