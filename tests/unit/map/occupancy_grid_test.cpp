// SPDX-License-Identifier: BSD-3-Clause
#include "core/map/occupancy_grid.h"

#include <gtest/gtest.h>

#include <random>

namespace plslam {
namespace {

constexpr int kTile = GridTiles::kTile;

OccupancyGrid RandomGrid(int first_column, int first_row, int n_columns, int n_rows) {
  OccupancyGrid grid{SE3(), 0.1, 0.05, first_column, first_row, n_columns, n_rows, {}};
  std::mt19937 random(7);
  for (int i = 0; i < n_columns * n_rows; ++i) {
    grid.cells.push_back(random() % 2 == 0 ? OccupancyGrid::kFree : OccupancyGrid::kOccupied);
  }
  return grid;
}

void ExpectSameCells(const OccupancyGrid& expected, const OccupancyGrid& actual) {
  for (int row = expected.first_row - 5; row < expected.first_row + expected.n_rows + 5; ++row) {
    for (int column = expected.first_column - 5; column < expected.first_column + expected.n_columns + 5; ++column) {
      ASSERT_EQ(expected.At(column, row), actual.At(column, row)) << column << " " << row;
    }
  }
}

TEST(GridTiles, ChangedTilesRebuildTheGrid) {
  GridTiles sender, receiver;
  const auto send = [&](const OccupancyGrid& grid) {
    const std::vector<OccupancyGrid> changed = sender.Update(grid);
    for (const OccupancyGrid& tile : changed) EXPECT_TRUE(receiver.Add(tile));
    return changed.size();
  };
  OccupancyGrid grid = RandomGrid(-200, -1, 300, 140);
  EXPECT_EQ(send(grid), 9U) << "columns -2 to 0, rows -1 to 1";
  ExpectSameCells(grid, receiver.Whole());
  EXPECT_EQ(send(grid), 0U);
  grid.cells.front() = OccupancyGrid::kUnknown;
  EXPECT_EQ(send(grid), 1U);
  ExpectSameCells(grid, receiver.Whole());
  // Tiles that the grid has left become unknown.
  grid = RandomGrid(0, 0, 10, 10);
  EXPECT_EQ(send(grid), 9U);
  ExpectSameCells(grid, receiver.Whole());
  EXPECT_EQ(receiver.Whole().At(-150, 50), OccupancyGrid::kUnknown);
}

TEST(GridTiles, ImpossibleTilesAreRefused) {
  GridTiles tiles;
  OccupancyGrid tile = RandomGrid(kTile, -kTile, kTile, kTile);
  EXPECT_TRUE(tiles.Add(tile));
  const auto refused = [&](auto change) {
    OccupancyGrid other = tile;
    change(other);
    return !tiles.Add(other);
  };
  EXPECT_TRUE(refused([](OccupancyGrid& t) { t.first_row = 5; }));
  EXPECT_TRUE(refused([](OccupancyGrid& t) { t.cells.pop_back(); }));
  EXPECT_TRUE(refused([](OccupancyGrid& t) { t.n_columns = 2 * kTile; }));
  EXPECT_TRUE(refused([](OccupancyGrid& t) { t.cell_m = 0.0; }));
  EXPECT_TRUE(refused([](OccupancyGrid& t) { t.first_column = 1 << 30; }));
  EXPECT_TRUE(refused([](OccupancyGrid& t) { t.first_column = t.first_row = kTile * 100'000; })) << "too large";
  EXPECT_EQ(tiles.Whole().n_columns, kTile);
}

}  // namespace
}  // namespace plslam
