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

/// Decides which pairs of a live stereo camera are worth a picture: the board stands still in both images, at a place,
/// distance or tilt that no picture has yet. Says what is missing until pictures of all kinds are there.
class PictureTaker {
 public:
  PictureTaker(const Board& board, const ImageSize& size) : board_(board), size_(size) {}

  /// What was seen of the board (nothing: empty) at a time in seconds, in the order of time. True where it is worth a
  /// picture, which then counts as taken.
  bool Add(const BoardView& left, const BoardView& right, double t_s);

  /// Sentences, the most important first; empty where nothing is missing.
  std::vector<std::string> Missing() const;

  int pictures() const { return pictures_; }
  const std::vector<Eigen::Vector2d>& pixels(bool is_right) const { return pixels_[is_right ? 1 : 0]; }
  const ImageSize& size() const { return size_; }

 private:
  /// How the board stands in the left image, in coarse steps.
  struct Stance {
    int column = 0, row = 0, scale = 0;
    bool left = false, right = false, up = false, down = false;  ///< where it is turned to
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
