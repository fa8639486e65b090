// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include <opencv2/core/mat.hpp>

#include "tools/calibration/board.h"
#include "tools/calibration/markers.h"

namespace plslam::calibration {

/// Counts images that contradict the given board: their markers lie at other positions, or none of them shows one of its
/// edges.
class BoardFaults {
 public:
  explicit BoardFaults(const Board& board) : board_(board) {}

  void Count(const BoardView& view);

  /// A sentence where more than a quarter of the images contradict the board; empty otherwise.
  std::string Contradiction() const;

  /// A sentence where no image shows a corner of the first or last row or column of corners: markers are numbered row by
  /// row, and those of a board with one row less lie as they should. Empty otherwise, and after too few images of a
  /// board.
  std::string UnseenEdge() const;

 private:
  Board board_;
  int images_ = 0;
  int contradictions_ = 0;
  int images_with_board_ = 0;
  /// Range of the corners seen.
  int first_row_ = kNone, last_row_ = -1;
  int first_column_ = kNone, last_column_ = -1;
  static constexpr int kNone = 1 << 20;
};

/// For the sentence about a chess board that is not detected in `image`: "; chess:9x6:0.025 is seen in one: ..." if a
/// board of another size, a common mistake, is detected there. Empty otherwise.
std::string OtherSizeSeen(const Board& board, const cv::Mat& image);

}  // namespace plslam::calibration
