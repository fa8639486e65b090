// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include <opencv2/core/mat.hpp>

#include "tools/calibration/board.h"
#include "tools/calibration/markers.h"

namespace plslam::calibration {

/// Counts what images say about a wrong board: markers that lie otherwise than it says.
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

/// For the sentence about a chess board that is not seen in `image`: "; chess:9x6:0.025 is seen in one: ..." where a
/// board of another size is seen there, which people write in its place. Empty otherwise.
std::string OtherSizeSeen(const Board& board, const cv::Mat& image);

}  // namespace plslam::calibration
