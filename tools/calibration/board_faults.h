// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include <opencv2/core/mat.hpp>

#include "tools/calibration/board.h"
#include "tools/calibration/markers.h"

namespace plslam::calibration {

/// Counts images that contradict the given board: their markers lie at other positions.
class BoardFaults {
 public:
  void Count(const BoardView& view) {
    ++images_;
    if (view.contradicts) ++contradictions_;
  }

  /// A sentence where more than a quarter of the images contradict the board; empty otherwise.
  std::string Sentence(const Board& board) const;

 private:
  int images_ = 0;
  int contradictions_ = 0;
};

/// For the sentence about a chess board that is not detected in `image`: "; chess:9x6:0.025 is seen in one: ..." if a
/// board of another size, a common mistake, is detected there. Empty otherwise.
std::string OtherSizeSeen(const Board& board, const cv::Mat& image);

}  // namespace plslam::calibration
