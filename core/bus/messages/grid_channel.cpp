// SPDX-License-Identifier: BSD-3-Clause
#include "core/bus/messages/grid_channel.h"

#include <algorithm>
#include <optional>

#include "core/bus/channels.h"
#include "core/bus/messages/convert.h"
#include "plslam/grid_t.hpp"

namespace plslam::bus {
namespace {

grid_t ToMessage(const OccupancyGrid& tile, int64_t number) {
  grid_t message{};
  message.grid = number;
  message.T_w_level = bus::ToMessage(tile.T_w_level);
  message.floor_m = tile.floor_m;
  message.cell_m = tile.cell_m;
  message.first_column = tile.first_column;
  message.first_row = tile.first_row;
  message.n_columns = static_cast<int16_t>(tile.n_columns);
  message.n_rows = static_cast<int16_t>(tile.n_rows);
  message.cells = tile.cells;
  message.n_cells = static_cast<int32_t>(tile.cells.size());
  return message;
}

std::optional<OccupancyGrid> FromMessage(const grid_t& message) {
  const std::optional<SE3> T_w_level = bus::FromMessage(message.T_w_level);
  const bool valid = std::ranges::all_of(message.cells, [](uint8_t cell) {
    return cell == OccupancyGrid::kUnknown || cell == OccupancyGrid::kFree || cell == OccupancyGrid::kOccupied;
  });
  if (!T_w_level || !valid) return std::nullopt;
  return OccupancyGrid{*T_w_level,        message.floor_m,   message.cell_m, message.first_column,
                       message.first_row, message.n_columns, message.n_rows, message.cells};
}

bool IsSameFrame(const OccupancyGrid& a, const OccupancyGrid& b) {
  return a.cell_m == b.cell_m && a.T_w_level.rotation().coeffs() == b.T_w_level.rotation().coeffs() &&
         a.T_w_level.translation() == b.T_w_level.translation();
}

}  // namespace

void GridPublisher::Publish(const OccupancyGrid& grid) {
  if (!IsSameFrame(frame_, grid)) {
    ++number_;
    tiles_ = {};
    frame_ = grid;
    frame_.cells = {};
  }
  for (const OccupancyGrid& tile : tiles_.Update(grid)) {
    grid_t message = ToMessage(tile, number_);
    bus_.Publish(kGrid, message);
    ++n_tiles_;
  }
}

void GridPublisher::Clear() {
  if (tiles_.empty()) return;
  OccupancyGrid none = frame_;
  none.n_columns = none.n_rows = 0;
  Publish(none);
}

GridSubscriber::GridSubscriber(Bus& bus, std::function<void()> handler) {
  bus.Subscribe<grid_t>(kGrid, [this, &bus, handler = std::move(handler)](const grid_t& message) {
    if (!received_.Add(message.header.source)) return;
    const std::optional<OccupancyGrid> tile = FromMessage(message);
    const std::pair<int64_t, int64_t> number{message.header.source, message.grid};
    GridTiles replaced = number == number_ ? std::move(tiles_) : GridTiles();
    const bool ok = tile && replaced.Add(*tile);
    if (ok || number == number_) tiles_ = std::move(replaced);
    if (!ok) return bus.CountRejected();
    number_ = number;
    handler();
  });
}

}  // namespace plslam::bus
