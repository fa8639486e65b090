// SPDX-License-Identifier: BSD-3-Clause
#include "adapter/node/map_sink.h"

#include <chrono>

#include "adapter/node/foreign_messages.h"

namespace plslam::adapter {

MapSink::MapSink(bus::Process& process, bus::StockLcm& foreign, const std::string& channel)
    : process_(process),
      foreign_(foreign),
      channel_(channel),
      map_(process.bus(), [this](const MapUpdate& update) { changed_t_ns_ = update.t_ns; }) {
  process_.bus().Every(std::chrono::milliseconds(1000), [this] { Tick(); });
}

void MapSink::SetBody(const SE3& T_b_c) {
  const std::scoped_lock lock(mutex_);
  T_b_c_ = T_b_c;
}

void MapSink::Tick() {
  std::unique_lock lock(mutex_);
  const std::optional<SE3> T_b_c = T_b_c_;
  lock.unlock();
  if (!T_b_c || !changed_t_ns_) return;
  const bool sent =
      foreign_.Publish(channel_, bus::Encoded(ToPointCloud(*T_b_c, map_.follower().map(), *changed_t_ns_)));
  if (!sent) return;
  changed_t_ns_.reset();
  process_.SetCounter("maps.sent", static_cast<double>(++n_sent_));
}

}  // namespace plslam::adapter
