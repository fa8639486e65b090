// SPDX-License-Identifier: BSD-3-Clause
#include "core/map/occupancy_grid.h"

#include <algorithm>
#include <cmath>

namespace plslam {
namespace {

constexpr int kTile = GridTiles::kTile;
/// Bound of columns and rows: sums of two stay within an int.
constexpr int kMostColumn = 1 << 24;

int TileOf(int cell) { return (cell >= 0 ? cell : cell - kTile + 1) / kTile; }

/// Columns and rows from the first to the last tile, in tiles.
struct Extent {
  int first_row, last_row, first_column, last_column;

  void Include(const std::pair<int, int>& place) {
    first_row = std::min(first_row, place.first);
    last_row = std::max(last_row, place.first);
    first_column = std::min(first_column, place.second);
    last_column = std::max(last_column, place.second);
  }
  int64_t cells() const {
    return int64_t{kTile} * kTile * (int64_t{last_row} - first_row + 1) * (int64_t{last_column} - first_column + 1);
  }
};

template <class Tiles>
Extent ExtentOf(const Tiles& tiles) {
  const std::pair<int, int>& first = tiles.begin()->first;
  Extent extent{first.first, first.first, first.second, first.second};
  for (const auto& [place, cells] : tiles) extent.Include(place);
  return extent;
}

OccupancyGrid Empty(const OccupancyGrid& frame, int first_column, int first_row, int n_columns, int n_rows) {
  OccupancyGrid grid{frame.T_w_level, frame.floor_m, frame.cell_m, first_column, first_row, n_columns, n_rows, {}};
  grid.cells.assign(static_cast<size_t>(n_columns) * static_cast<size_t>(n_rows), OccupancyGrid::kUnknown);
  return grid;
}

}  // namespace

uint8_t OccupancyGrid::At(int column, int row) const {
  const int x = column - first_column, y = row - first_row;
  if (x < 0 || y < 0 || x >= n_columns || y >= n_rows) return kUnknown;
  return cells[static_cast<size_t>(y) * static_cast<size_t>(n_columns) + static_cast<size_t>(x)];
}

std::vector<OccupancyGrid> GridTiles::Update(const OccupancyGrid& grid) {
  std::map<Place, OccupancyGrid> now;
  const auto tile_at = [&](const Place& place) -> OccupancyGrid& {
    const auto [tile, is_new] = now.try_emplace(place);
    if (is_new) tile->second = Empty(grid, kTile * place.second, kTile * place.first, kTile, kTile);
    return tile->second;
  };
  for (const auto& [place, cells] : tiles_) tile_at(place);
  for (int y = 0; y < grid.n_rows; ++y) {
    for (int x = 0; x < grid.n_columns; ++x) {
      const int column = grid.first_column + x, row = grid.first_row + y;
      const uint8_t cell = grid.At(column, row);
      if (cell == OccupancyGrid::kUnknown) continue;
      OccupancyGrid& tile = tile_at({TileOf(row), TileOf(column)});
      tile.cells[static_cast<size_t>(row - tile.first_row) * kTile +
                 static_cast<size_t>(column - tile.first_column)] = cell;
    }
  }
  std::vector<OccupancyGrid> changed;
  for (auto& [place, tile] : now) {
    std::vector<uint8_t>& before = tiles_[place];
    if (before == tile.cells) continue;
    before = tile.cells;
    changed.push_back(std::move(tile));
  }
  newest_ = Empty(grid, 0, 0, 0, 0);
  return changed;
}

bool GridTiles::Add(const OccupancyGrid& tile) {
  const auto is_place = [](int first) { return std::abs(first) <= kMostColumn && first % kTile == 0; };
  if (tile.n_columns != kTile || tile.n_rows != kTile || tile.cells.size() != size_t{kTile} * kTile ||
      !is_place(tile.first_column) || !is_place(tile.first_row) || !(tile.cell_m > 0.0) ||
      !std::isfinite(tile.cell_m) || !std::isfinite(tile.floor_m)) {
    return false;
  }
  const Place place{TileOf(tile.first_row), TileOf(tile.first_column)};
  if (!tiles_.empty()) {
    Extent extent = ExtentOf(tiles_);
    extent.Include(place);
    if (extent.cells() > kMostCells) return false;
  }
  tiles_[place] = tile.cells;
  newest_ = Empty(tile, 0, 0, 0, 0);
  return true;
}

OccupancyGrid GridTiles::Whole() const {
  if (tiles_.empty()) return newest_;
  const Extent extent = ExtentOf(tiles_);
  OccupancyGrid grid =
      Empty(newest_, kTile * extent.first_column, kTile * extent.first_row,
            kTile * (extent.last_column - extent.first_column + 1), kTile * (extent.last_row - extent.first_row + 1));
  for (const auto& [place, cells] : tiles_) {
    const int x = kTile * place.second - grid.first_column, y = kTile * place.first - grid.first_row;
    for (int row = 0; row < kTile; ++row) {
      std::copy_n(cells.begin() + row * kTile, kTile,
                  grid.cells.begin() + static_cast<ptrdiff_t>(y + row) * grid.n_columns + x);
    }
  }
  return grid;
}

}  // namespace plslam
