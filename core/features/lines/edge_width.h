// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "core/features/image/gradients.h"
#include "core/geometry/segment.h"

namespace plslam {

inline constexpr int kMaxEdgeWidth_px = 13;

/// Over how many pixels across a directed segment its edge rises: places side by side, the segment's own among them,
/// whose gradient towards the brighter side, in the mean along the segment, is at least half of the largest near it.
/// A sharp edge has 3 or 4, one that motion has blurred as many as the blur is long; `kMaxEdgeWidth_px` at most. 0
/// for a segment without length.
int EdgeWidth_px(const Gradients& gradients, const Segment2& segment);

}  // namespace plslam
