// SPDX-License-Identifier: BSD-3-Clause
#include "tools/calibration/board_faults.h"

#include <algorithm>
#include <utility>

#include <fmt/format.h>

namespace plslam::calibration {

namespace {

/// A board that is held at so few positions may stay partly out of all images.
constexpr int kEnoughImages = 10;

}  // namespace

void BoardFaults::Count(const BoardView& view) {
  ++images_;
  if (view.contradicts) ++contradictions_;
  if (!view.corners.empty()) ++images_with_board_;
  for (const int corner : view.corners) {
    const int row = corner / board_.CornerColumns(), column = corner % board_.CornerColumns();
    first_row_ = std::min(first_row_, row);
    last_row_ = std::max(last_row_, row);
    first_column_ = std::min(first_column_, column);
    last_column_ = std::max(last_column_, column);
  }
}

std::string BoardFaults::Contradiction() const {
  if (4 * contradictions_ <= images_) return "";
  return fmt::format(
      "the markers do not lie as on the board {} (in {} of {} pictures): does the board have other columns and rows?",
      BoardText(board_), contradictions_, images_);
}

std::string BoardFaults::UnseenEdge() const {
  if (images_with_board_ < kEnoughImages) return "";
  const char* edge = last_row_ < board_.CornerRows() - 1         ? "lowest row"
                     : first_row_ > 0                            ? "uppermost row"
                     : last_column_ < board_.CornerColumns() - 1 ? "rightmost column"
                     : first_column_ > 0                         ? "leftmost column"
                                                                 : nullptr;
  if (edge == nullptr) return "";
  return fmt::format(
      "none of {} pictures shows the {} of the board {}: does the board have fewer columns or rows? If not, hold it "
      "where the whole board is seen",
      images_with_board_, edge, BoardText(board_));
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
