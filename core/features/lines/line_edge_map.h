// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include <opencv2/core/mat.hpp>

#include "core/features/image/gradients.h"

namespace plslam {

/// Marks in an edge map.
enum EdgeMark : uint8_t {
  kNoEdge = 0,
  kSteepEdge = 1,  ///< |dx| >= |dy|: peak of |dx| along its row.
  kFlatEdge = 2,   ///< |dy| > |dx|: peak of |dy| along its column.
  kUsedEdge = 4,   ///< Part of a segment already.
  kTriedEdge = 8,  ///< Part of a failed one; no seed any more.
};

/// Thin edges: pixels whose larger gradient component is at least `threshold` and a peak along its own axis. The
/// outermost two pixels on each side are never marked. `out` is CV_8UC1 of the size of the gradients.
void ComputeEdgeMap(const Gradients& gradients, int threshold, cv::Mat& out);

}  // namespace plslam
