// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <utility>
#include <vector>

#include <Eigen/Core>

namespace plslam::vo {

/// Regions of a rectified image that dirt on the lens covers, in square cells.
class DirtCells {
 public:
  static constexpr int kCell_px = 8;

  /// Without dirt anywhere.
  DirtCells() = default;
  /// `cells` are not zero where there is dirt; row by row, of `columns`.
  DirtCells(std::vector<char> cells, int columns) : cells_(std::move(cells)), columns_(columns) {}

  bool empty() const { return cells_.empty(); }

  /// False outside the image.
  bool IsOn(const Eigen::Vector2d& px) const {
    if (empty() || !(px.x() >= 0.0) || !(px.y() >= 0.0) || px.x() >= 1.0 * columns_ * kCell_px) return false;
    const auto cell = static_cast<size_t>(px.y() / kCell_px) * static_cast<size_t>(columns_) +
                      static_cast<size_t>(px.x() / kCell_px);
    return cell < cells_.size() && cells_[cell] != 0;
  }

 private:
  std::vector<char> cells_;
  int columns_ = 0;
};

/// Dirt on the two lenses.
struct PairDirt {
  DirtCells left;
  DirtCells right;

  bool empty() const { return left.empty() && right.empty(); }
};

}  // namespace plslam::vo
