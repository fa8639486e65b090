// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <functional>
#include <optional>

#include "core/bus/messages/grid_channel.h"
#include "core/bus/messages/submap_channel.h"

namespace plslam {
class status_t;
}  // namespace plslam

namespace plslam::viewer {

/// Surface points and grid of dense_process as received, and whether more are to come.
class HeardSurfaces {
 public:
  /// `on_news` is called after each message.
  HeardSurfaces(bus::Bus& bus, const std::function<void()>& on_news) : grid_(bus, on_news), submaps_(bus, on_news) {}

  void OnStatus(const status_t& message);

  /// Whether a dense_process is at work, or has published messages that have not arrived.
  bool MayCome() const;
  const SurfaceCloud& cloud() const { return submaps_.cloud(); }
  OccupancyGrid Grid() const { return grid_.Whole(); }

 private:
  /// The newest status of a dense_process.
  struct Publisher {
    int64_t source = 0;
    bool has_finished = false;
    int64_t n_tiles = 0;
    int64_t n_submaps = 0;
  };

  std::optional<Publisher> publisher_;
  bus::GridSubscriber grid_;
  bus::SubmapSubscriber submaps_;
};

}  // namespace plslam::viewer
