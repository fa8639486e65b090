// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "core/bus/messages/grid_channel.h"
#include "core/bus/messages/submap_channel.h"
#include "core/map/map.h"
#include "core/map/vertical.h"
#include "dense_process/dense_map.h"
#include "dense_process/products.h"

namespace plslam::dense {

/// Grid and surface points on the bus, for robots and viewers. While surfaces grow they are made again at most every two
/// seconds, and in at most a tenth of the time of the process. The vertical of the grid stays while that of the map is
/// within 0.3 degrees: small changes would change all cells.
class LiveProducts {
 public:
  /// `robot_height_m`: upper bound of obstacles; `up_c` as for `VerticalOf`.
  LiveProducts(bus::Bus& bus, double robot_height_m, std::vector<double> up_c)
      : grid_(bus), submaps_(bus), robot_height_m_(robot_height_m), up_c_(std::move(up_c)) {}

  /// The surfaces have changed since they were published.
  void Outdate() { is_old_ = true; }
  bool IsDue(double now_ms) const { return is_old_ && now_ms >= next_ms_; }
  /// Publishes what has changed, the grid if the surfaces have a floor, and returns the time of that, in ms. A failure
  /// is logged. `began_ms`: now.
  double Publish(const DenseMap& surfaces, const Map& map, double began_ms);
  /// Publishes grid and cloud of the files.
  void PublishFinal(const Products& products, const SurfaceCloud& cloud);
  /// Another map has replaced that of the surfaces.
  void Replace() {
    grid_.Clear();
    submaps_.Replace();
  }

  /// Numbers of published tiles of the grid, and of published submaps.
  int64_t n_tiles() const { return grid_.n_tiles(); }
  int64_t n_submaps() const { return submaps_.n_submaps(); }

  /// The vertical of the grid; nullopt before the first one.
  const std::optional<Vertical>& vertical() const { return vertical_; }

 private:
  void SendGrid(const Products& products);

  bus::GridPublisher grid_;
  bus::SubmapPublisher submaps_;
  double robot_height_m_;
  std::vector<double> up_c_;
  bool is_old_ = false;
  bool has_no_grid_ = false;  ///< once it was too large, which is logged once
  double next_ms_ = 0.0;
  std::optional<Vertical> vertical_;
};

}  // namespace plslam::dense
