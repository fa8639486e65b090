// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <set>
#include <string>
#include <tuple>
#include <vector>

#include <Eigen/Core>

#include "tools/calibration/board.h"
#include "tools/calibration/coverage.h"
#include "tools/calibration/markers.h"

namespace plslam::calibration {

/// Decides which pairs of a live stereo camera are worth a picture: the board is static in both images, at a position,
/// distance or tilt that no picture has yet. Reports missing views until all types of views have been taken.
class PictureTaker {
 public:
  PictureTaker(const Board& board, const ImageSize& size) : board_(board), size_(size) {}

  /// Adds the views of the board (empty: not seen) at a time in seconds, in order of time. Returns true if they are
  /// worth a picture, which then counts as taken.
  bool Add(const BoardView& left, const BoardView& right, double t_s);

  /// Sentences about missing views, the most important first; empty if none are missing.
  std::vector<std::string> Missing() const;

  int pictures() const { return pictures_; }
  const std::vector<Eigen::Vector2d>& pixels(bool is_right) const { return pixels_[is_right ? 1 : 0]; }
  const ImageSize& size() const { return size_; }

 private:
  /// Pose of the board in the left image, in coarse steps.
  struct Stance {
    int column = 0, row = 0, scale = 0;
    bool left = false, right = false, up = false, down = false;  ///< directions of its tilt
    auto Key() const { return std::tuple(column, row, scale, left, right, up, down); }
    bool operator<(const Stance& other) const { return Key() < other.Key(); }
  };
  bool IsStill(const BoardView& left, const BoardView& right, double t_s);
  Stance StanceOf(const BoardView& view) const;
  bool IsNewPlace(const BoardView& view, bool is_right) const;
  void Count(const BoardView& view, bool is_right);

  Board board_;
  ImageSize size_;
  BoardView last_left_, last_right_;
  BoardView taken_left_, taken_right_;  ///< of the last picture
  int still_looks_ = 0;
  double still_since_s_ = 0.0;
  int pictures_ = 0;
  std::set<Stance> stances_;
  std::array<std::vector<Eigen::Vector2d>, 2> pixels_;
  std::array<std::set<size_t>, 2> cells_;
};

}  // namespace plslam::calibration
