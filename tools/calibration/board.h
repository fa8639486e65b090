// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

namespace plslam::calibration {

/// A flat calibration board. Frame: x right, y down, origin in the upper left corner of the pattern, z = 0; metres.
struct Board {
  enum class Kind { kChess, kCharuco };
  Kind kind = Kind::kChess;
  /// Inner corners of a chess board; squares of a Charuco board: each as OpenCV counts.
  int columns = 0;
  int rows = 0;
  double square_m = 0.0;
  /// Side of a Charuco board's markers.
  double marker_m = 0.0;

  int SquareColumns() const { return kind == Kind::kChess ? columns + 1 : columns; }
  int SquareRows() const { return kind == Kind::kChess ? rows + 1 : rows; }
  int CornerColumns() const { return SquareColumns() - 1; }
  int CornerRows() const { return SquareRows() - 1; }
};

/// Reads "chess:9x6:0.025" (inner corners, square) or "charuco:11x8:0.03:0.022" (squares, square, marker; markers of
/// OpenCV's dictionary DICT_5X5_250 in the order of OpenCV 4.6). Throws std::runtime_error with one sentence.
Board ParseBoard(const std::string& text);

/// The text that `ParseBoard` reads.
std::string BoardText(const Board& board);

/// Where the inner corners are, row by row from the upper left one.
std::vector<Eigen::Vector2d> BoardCorners(const Board& board);

/// A black area of the board.
struct BlackRectangle {
  Eigen::Vector2d upper_left_m;
  Eigen::Vector2d size_m;
};

/// All that is black on the board.
std::vector<BlackRectangle> BoardPattern(const Board& board);

/// The board as a PDF of one page that is as large as the board with a margin: printed without scaling, squares have
/// their size.
std::string BoardPdf(const Board& board);

}  // namespace plslam::calibration
