// SPDX-License-Identifier: BSD-3-Clause
#include "tools/calibration/coverage.h"

#include <algorithm>
#include <array>

namespace plslam::calibration {

size_t CellOf(const Eigen::Vector2d& pixel, const ImageSize& size, int columns, int rows) {
  const int column = std::clamp(static_cast<int>((pixel.x() + 0.5) * columns / size.width_px), 0, columns - 1);
  const int row = std::clamp(static_cast<int>((pixel.y() + 0.5) * rows / size.height_px), 0, rows - 1);
  return static_cast<size_t>(row * columns + column);
}

std::vector<int> CountsOfCells(const std::vector<Eigen::Vector2d>& pixels, const ImageSize& size, int columns,
                               int rows) {
  std::vector<int> counts(static_cast<size_t>(columns * rows), 0);
  for (const Eigen::Vector2d& p : pixels) ++counts[CellOf(p, size, columns, rows)];
  return counts;
}

std::vector<std::string> CoveragePicture(const std::vector<Eigen::Vector2d>& pixels, const ImageSize& size) {
  const std::vector<int> counts = CountsOfCells(pixels, size, kCoverageColumns, kCoverageRows);
  std::vector<std::string> picture;
  for (int row = 0; row < kCoverageRows; ++row) {
    picture.emplace_back();
    for (int column = 0; column < kCoverageColumns; ++column) {
      const int n = counts[static_cast<size_t>(row * kCoverageColumns + column)];
      picture.back() += n == 0 ? ' ' : n < 3 ? '.' : n < 10 ? 'o' : '#';
    }
  }
  return picture;
}

std::vector<std::string> EmptyRegions(const std::vector<Eigen::Vector2d>& pixels, const ImageSize& size) {
  constexpr std::array kNames = {"upper left corner", "upper edge", "upper right corner",
                                 "left edge",         "centre",     "right edge",
                                 "lower left corner", "lower edge", "lower right corner"};
  constexpr int kSide = 4;         // cells of a ninth
  constexpr int kEnoughCells = 3;  // of its 16
  const std::vector<int> counts = CountsOfCells(pixels, size, 3 * kSide, 3 * kSide);
  std::array<int, kNames.size()> covered{};
  for (size_t i = 0; i < counts.size(); ++i) {
    const size_t row = i / (3 * kSide) / kSide, column = i % (3 * kSide) / kSide;
    covered[3 * row + column] += counts[i] > 0 ? 1 : 0;
  }
  std::vector<std::string> names;
  for (size_t i = 0; i < kNames.size(); ++i) {
    if (covered[i] < kEnoughCells) names.emplace_back(kNames[i]);
  }
  return names;
}

}  // namespace plslam::calibration
