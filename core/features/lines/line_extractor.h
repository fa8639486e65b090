// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <vector>

#include <opencv2/core/mat.hpp>

#include "core/features/features.h"
#include "core/features/options.h"

namespace plslam {

/// Extracts line segments of one rectified 8-bit image with their descriptors (PL-SLAM §IV.B).
///
/// Segments are directed (the brighter side is on the right of p->q as seen in the image), at least `min_length_px`
/// long, free of duplicates, with collinear pieces of one edge joined. At most `max_lines` are kept, the longest,
/// spread over the image. `response` is the contrast across the segment in grey levels. If few are sharp, halved images
/// are searched, too; `octave` is the number of halvings of the line's image (`CoarseLines`).
///
/// Use one extractor per image stream and thread: it keeps buffers between images, never results. Any image from 1x1 is
/// accepted; an empty or structureless one gives none. Throws std::invalid_argument for another type than CV_8UC1.
class LineExtractor {
 public:
  explicit LineExtractor(const LineOptions& options);
  ~LineExtractor();
  LineExtractor(LineExtractor&&) noexcept;
  LineExtractor& operator=(LineExtractor&&) noexcept;

  std::vector<LineFeature> Extract(const cv::Mat& image);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace plslam
