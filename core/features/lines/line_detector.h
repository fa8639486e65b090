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

/// A detected segment.
struct DetectedSegment {
  Segment2 segment;
  /// Mean contrast across the segment, in grey levels; positive: the brighter side is on the right of p->q.
  double contrast = 0.0;
  /// Number of halvings of the image in which it was detected.
  int octave = 0;
};

/// A detector of straight edges in an image (PL-SLAM §IV.B). Implementations keep buffers, never results.
class LineDetector {
 public:
  virtual ~LineDetector() = default;

  /// Returns directed segments, unordered, possibly in pieces and of any length; `gradients` are those of `image`
  /// (CV_8UC1, any size).
  virtual std::vector<DetectedSegment> Detect(const cv::Mat& image, const Gradients& gradients) = 0;
};

/// Returns the detector `options.detector`.
std::unique_ptr<LineDetector> MakeLineDetector(const LineOptions& options);

/// Return one of the two detectors.
std::unique_ptr<LineDetector> MakeEdgeChainDetector(const LineOptions& options);
std::unique_ptr<LineDetector> MakeLsdDetector(const LineOptions& options);

/// Returns the segment directed with its brighter side on the right, and its contrast according to the gradients.
DetectedSegment Direct(const Segment2& segment, const Gradients& gradients);

}  // namespace plslam
