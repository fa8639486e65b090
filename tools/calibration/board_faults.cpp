// SPDX-License-Identifier: BSD-3-Clause
#include "tools/calibration/board_faults.h"

#include <algorithm>
#include <utility>

#include <fmt/format.h>

namespace plslam::calibration {

std::string BoardFaults::Sentence(const Board& board) const {
  if (4 * contradictions_ <= images_) return "";
  return fmt::format(
      "the markers do not lie as on the board {} (in {} of {} pictures): does the board have other columns and rows?",
      BoardText(board), contradictions_, images_);
}

std::string OtherSizeSeen(const Board& board, const cv::Mat& image) {
  if (board.kind != Board::Kind::kChess) return "";
  for (const auto& [columns, rows] :
       {std::pair(-1, -1), std::pair(1, 1), std::pair(-1, 0), std::pair(0, -1), std::pair(1, 0), std::pair(0, 1)}) {
    Board other = board;
    other.columns += columns;
    other.rows += rows;
    if (std::min(other.columns, other.rows) < 3 || FindBoard(other, image).corners.empty()) continue;
    return fmt::format("; {} is seen in one of them: count the inner corners", BoardText(other));
  }
  return "";
}

}  // namespace plslam::calibration
