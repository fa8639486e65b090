// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <memory>
#include <mutex>

#include "core/bus/bus.h"
#include "core/bus/messages/map_pages.h"
#include "core/map/map_follower.h"

namespace plslam::bus {

/// Publishes the map: its owner publishes every version once, in order, beginning with 1, the first on base version 0.
class MapUpdatePublisher {
 public:
  /// `asked`: a listener lacks published versions. Called on the thread of `Bus::Run`; the owner of the map then
  /// publishes `WholeMap` under its current version, in order with its updates. One complete map answers all requests
  /// until then.
  MapUpdatePublisher(Bus& bus, std::function<void()> asked);

  /// Safe from any thread. Throws the exceptions of CutIntoPages.
  void Publish(const MapUpdate& update);

 private:
  struct State;
  Bus& bus_;
  std::mutex publishing_;  // pages of two updates must not mix
  std::shared_ptr<State> state_;
};

/// Receives every update of the map in order, on the thread of `Bus::Run`: requests the complete map if one is missing,
/// at the start too, and again every 500 ms until it arrives. When mapping_process has restarted, its new map replaces
/// the old one; of two publishers the one that was heard first is the old one. Invalid pages are counted in
/// `BusCounters::rejected`.
class MapUpdateSubscriber {
 public:
  MapUpdateSubscriber(Bus& bus, std::function<void(MapUpdate)> handler);

 private:
  struct State;
  std::shared_ptr<State> state_;
};

/// Keeps a copy of the map, by all its updates.
class MapSubscriber {
 public:
  /// `handler` gets each update after the copy has taken it over.
  MapSubscriber(Bus& bus, std::function<void(const MapUpdate&)> handler);

  const MapFollower& follower() const { return *follower_; }
  /// `MapFollower::RememberRemoved`.
  void RememberRemoved() { follower_->RememberRemoved(); }
  /// `Map::ForgetRemoved`.
  void ForgetRemoved(const std::set<KeyframeId>& ids) { follower_->ForgetRemoved(ids); }

 private:
  std::shared_ptr<MapFollower> follower_ = std::make_shared<MapFollower>();
  MapUpdateSubscriber updates_;
};

}  // namespace plslam::bus
