// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <utility>
#include <vector>

#include "core/bus/bus.h"
#include "core/bus/messages/pager.h"
#include "core/bus/messages/received_messages.h"
#include "core/map/surface_cloud.h"
#include "plslam/submap_t.hpp"

namespace plslam::bus {

/// A submap as its message has it.
struct SubmapMessage {
  std::pair<int64_t, int64_t> surfaces;  ///< source and number
  int number = 0;
  double voxel_m = 0.0;
  bool only_moved = false;
  SubmapCloud submap;
};

/// Returns pages of at most `page_bytes`. Throws std::invalid_argument if those are too small.
std::vector<submap_t> CutIntoPages(const SubmapMessage& message, int64_t page_bytes);

/// Puts submaps together again.
class SubmapAssembler : public PageAssembler<submap_t, SubmapMessage> {
 public:
  SubmapAssembler();
};

/// Publishes surfaces: the submaps that have changed.
class SubmapPublisher {
 public:
  explicit SubmapPublisher(Bus& bus) : bus_(bus) {}

  /// Changes that are published. kSurfaces: poses, and points if surfaces have appeared or disappeared in a submap;
  /// small movements of points, which every new image causes, are not sent. kAll: every difference.
  enum class Changes { kSurfaces, kAll };
  void Publish(const SurfaceCloud& cloud, Changes changes);
  /// Begins new surfaces, which replace those before.
  void Replace();
  /// Number of published submaps.
  int64_t n_submaps() const { return n_submaps_; }

 private:
  void Send(const SubmapMessage& message);

  Bus& bus_;
  int64_t n_submaps_ = 0;
  int64_t number_ = 1;
  SurfaceCloud published_;
};

/// Keeps a copy of the surfaces of the newest publisher. Pages from the wire are checked; invalid ones are
/// counted in `BusCounters::rejected`.
class SubmapSubscriber {
 public:
  /// `handler` is called after each submap, on the thread of `Bus::Run`.
  SubmapSubscriber(Bus& bus, std::function<void()> handler);
  SubmapSubscriber(const SubmapSubscriber&) = delete;
  SubmapSubscriber& operator=(const SubmapSubscriber&) = delete;

  /// The surfaces as far as their submaps have arrived.
  const SurfaceCloud& cloud() const { return cloud_; }
  /// The submaps so far.
  const ReceivedMessages& received() const { return received_; }

 private:
  bool Take(SubmapMessage message);

  std::pair<int64_t, int64_t> surfaces_;  ///< source and number
  SurfaceCloud cloud_;
  ReceivedMessages received_;
  std::shared_ptr<void> subscription_;
};

}  // namespace plslam::bus
