// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include "core/bus/messages/grid_channel.h"
#include "core/map/map.h"
#include "core/map/vertical.h"
#include "dense_process/dense_map.h"
#include "dense_process/products.h"

namespace plslam::dense {

/// The grid on the bus, for robots and viewers. While surfaces grow it is made again at most every two seconds, and in
/// at most a tenth of the time of the process. Its vertical stays while that of the map is within 0.3 degrees: small
/// changes would change all cells.
class LiveGrid {
 public:
  /// `robot_height_m`: upper bound of obstacles.
  LiveGrid(bus::Bus& bus, double robot_height_m) : publisher_(bus), robot_height_m_(robot_height_m) {}

  /// The surfaces have changed since the grid was published.
  void Outdate() { is_old_ = true; }
  bool IsDue(double now_ms) const { return is_old_ && now_ms >= next_ms_; }
  /// Publishes the grid of these surfaces, if they have a floor, and returns the time of that, in ms. A failure is
  /// logged. `began_ms`: now.
  double Publish(const DenseMap& surfaces, const Map& map, double began_ms);
  /// Publishes the grid of the files.
  void PublishFinal(const Products& products);

  /// The vertical of the grid; nullopt before the first one.
  const std::optional<Vertical>& vertical() const { return vertical_; }

 private:
  void Send(const Products& products);

  bus::GridPublisher publisher_;
  double robot_height_m_;
  bool is_old_ = false;
  double next_ms_ = 0.0;
  std::optional<Vertical> vertical_;
};

}  // namespace plslam::dense
