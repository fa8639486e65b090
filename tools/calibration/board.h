// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

namespace plslam::calibration {

/// A flat calibration board. Frame: x right, y down, origin in the upper left corner of the pattern, z = 0; metres.
struct Board {
  enum class Kind { kChess, kCharuco, kAprilgrid };
  Kind kind = Kind::kChess;
  /// Inner corners of a chess board; squares of a Charuco board: each as OpenCV counts. Tags of an Aprilgrid.
  int columns = 0;
  int rows = 0;
  /// Side of a square; of an Aprilgrid, from tag to tag.
  double square_m = 0.0;
  /// Side of a Charuco board's markers, or of an Aprilgrid's tags.
  double marker_m = 0.0;
  /// Aprilgrid only: distance between neighbouring tags, in sides of a tag.
  double spacing = 0.0;

  int SquareColumns() const { return kind == Kind::kChess ? columns + 1 : columns; }
  int SquareRows() const { return kind == Kind::kChess ? rows + 1 : rows; }
  int CornerColumns() const { return kind == Kind::kAprilgrid ? 2 * columns : SquareColumns() - 1; }
  int CornerRows() const { return kind == Kind::kAprilgrid ? 2 * rows : SquareRows() - 1; }
  /// Of the pattern. The tags of an Aprilgrid have small black squares at their corners, at its rim too.
  double width_m() const { return SquareColumns() * square_m + spacing * marker_m; }
  double height_m() const { return SquareRows() * square_m + spacing * marker_m; }
};

/// Reads "chess:9x6:0.025" (inner corners, square), "charuco:11x8:0.03:0.022" (squares, square, marker; markers of
/// OpenCV's dictionary DICT_5X5_250 in the order of OpenCV 4.6) or "aprilgrid:6x6:0.088:0.3" (Kalibr's: tags, side of
/// a tag, spacing in sides of a tag; tags 36h11 with a border of two cells, numbered row by row from the lower left).
/// Throws std::runtime_error with one sentence.
Board ParseBoard(const std::string& text);

/// The text that `ParseBoard` reads.
std::string BoardText(const Board& board);

/// Returns the inner corners of squares, or the corners of tags, row by row from the upper left one.
std::vector<Eigen::Vector2d> BoardCorners(const Board& board);

/// A black area of the board.
struct BlackRectangle {
  Eigen::Vector2d upper_left_m;
  Eigen::Vector2d size_m;
};

/// "squares of 30 mm", "tags of 88 mm".
std::string BoardMeasure(const Board& board);

/// All that is black on the board.
std::vector<BlackRectangle> BoardPattern(const Board& board);

}  // namespace plslam::calibration
