// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <functional>
#include <utility>

#include "core/bus/bus.h"
#include "core/bus/messages/received_messages.h"
#include "core/map/occupancy_grid.h"

namespace plslam::bus {

/// Publishes an occupancy grid: the tiles that have changed.
class GridPublisher {
 public:
  explicit GridPublisher(Bus& bus) : bus_(bus) {}

  /// A grid whose frame or size of cells differ from those before replaces it: all its tiles are sent.
  void Publish(const OccupancyGrid& grid);
  /// All cells become unknown: the map was replaced.
  void Clear();
  /// Number of published tiles.
  int64_t n_tiles() const { return n_tiles_; }

 private:
  Bus& bus_;
  int64_t n_tiles_ = 0;
  int64_t number_ = 0;
  OccupancyGrid frame_;
  GridTiles tiles_;
};

/// Keeps a copy of the grid of the newest publisher. Tiles from the wire are checked; invalid ones are counted in
/// `BusCounters::rejected`.
class GridSubscriber {
 public:
  /// `handler` is called after each tile, on the thread of `Bus::Run`.
  GridSubscriber(Bus& bus, std::function<void()> handler);
  GridSubscriber(const GridSubscriber&) = delete;
  GridSubscriber& operator=(const GridSubscriber&) = delete;

  /// The grid as far as its tiles have arrived.
  OccupancyGrid Whole() const { return tiles_.Whole(); }
  /// The tiles so far.
  const ReceivedMessages& received() const { return received_; }

 private:
  ReceivedMessages received_;
  std::pair<int64_t, int64_t> number_;  ///< source and number of the grid
  GridTiles tiles_;
};

}  // namespace plslam::bus
