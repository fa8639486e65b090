// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <string>

#include "core/files/notes.h"

namespace plslam {

/// Bright values of the images of a pair (`BrightWideValue` in core/io/images/image_file.h), 0 for 8-bit images.
/// `right` is that of `left` if it is a depth map.
struct BrightValues {
  int left = 0, right = 0;
};

/// Returns the white level of a sequence of `n_frames` pairs (`WhiteLevel` in core/io/images/image_file.h), one for all
/// frames and both cameras: that of the brightest of 16 pairs, spread over all of it. `bright_of` returns the values of
/// a pair; after a pair of 8-bit images no other pair is read, and a pair for which it throws is skipped. If the level
/// is less than 16 bits, `notes` says so. Throws DatasetError if one image of a pair has 8 bits and the other 16.
int WhiteLevelOf(int n_frames, const std::function<BrightValues(int frame)>& bright_of, Notes* notes);

/// Counts the frames with more than hot pixels above the white level. May be used by several threads.
class ClippedFrames {
 public:
  explicit ClippedFrames(int white) : white_(white) {}
  /// `clipped` are the parts of both images above the white level.
  void Add(int frame, double clipped_left, double clipped_right);
  /// A warning with their number; empty if there are none.
  Notes Report() const;

 private:
  int white_;
  std::atomic<int64_t> n_ = 0;
  std::atomic<int> first_ = -1;
};

}  // namespace plslam
