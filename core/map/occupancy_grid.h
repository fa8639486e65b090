// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <map>
#include <utility>
#include <vector>

#include "core/geometry/se3.h"

namespace plslam {

/// The floor for a robot: cells that are free, occupied, or unknown, in a level frame (z up). Cell (column, row) covers x
/// from column * cell_m and y from row * cell_m; columns and rows can be negative.
struct OccupancyGrid {
  static constexpr uint8_t kUnknown = 205, kFree = 254, kOccupied = 0;  ///< grey values of nav2's map_server

  SE3 T_w_level;
  double floor_m = 0.0;  ///< height of the floor below the first camera, in the level frame
  double cell_m = 0.0;
  int first_column = 0, first_row = 0;
  int n_columns = 0, n_rows = 0;
  std::vector<uint8_t> cells;  ///< n_columns * n_rows, row by row, the one with the smallest y first

  /// The value of a cell; unknown outside the grid.
  uint8_t At(int column, int row) const;
};

/// The tiles of a grid that change one by one. All have kTile x kTile cells and begin at multiples of kTile.
class GridTiles {
 public:
  static constexpr int kTile = 128;
  /// Larger grids are refused: a square of 3 km at 0.2 m.
  static constexpr int64_t kMostCells = int64_t{1} << 28;

  /// Takes over the cells of a grid of the same frame, and returns the tiles that differ from those before. Tiles that
  /// the grid does not reach become unknown.
  std::vector<OccupancyGrid> Update(const OccupancyGrid& grid);

  /// Takes over one tile. Returns false, without any change, if it is not one or makes the grid too large.
  bool Add(const OccupancyGrid& tile);

  /// The grid of all tiles; without cells if there is none. Frame and floor are those of the newest tile.
  OccupancyGrid Whole() const;

  bool empty() const { return tiles_.empty(); }

 private:
  using Place = std::pair<int, int>;  ///< row and column of the tile, in tiles
  OccupancyGrid newest_;              ///< frame, floor and size of a cell
  std::map<Place, std::vector<uint8_t>> tiles_;
};

}  // namespace plslam
