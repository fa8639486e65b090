// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>

#include "tools/calibration/board.h"

namespace plslam::calibration {

/// Sizes of the dictionaries of a Charuco board and of an Aprilgrid.
inline constexpr int kMaxMarkers = 250;
inline constexpr int kMaxTags = 587;

/// A marker of a board, upright, in the frame of the board.
struct Marker {
  Eigen::Vector2d upper_left_m;
  std::vector<bool> black;  ///< of its cells with the border, row by row
};

/// The markers of a Charuco board as OpenCV 4.6 lays them; the tags of an Aprilgrid as Kalibr does; none of a chess
/// board.
std::vector<Marker> MarkersOf(const Board& board);

/// A board seen in an image: indices into `BoardCorners` and pixels.
struct BoardView {
  std::vector<int> corners;
  std::vector<Eigen::Vector2d> pixels;
  /// The detected markers contradict the board: it has other columns or rows.
  bool contradicts = false;
};

/// Looks for the board in an 8-bit grey image. A chess board is seen whole or not at all (no corners), and where its
/// halves look alike, either way round.
BoardView FindBoard(const Board& board, const cv::Mat& image);

}  // namespace plslam::calibration
