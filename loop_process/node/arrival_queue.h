// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <mutex>
#include <optional>
#include <variant>

#include "core/geometry/stereo_camera.h"
#include "core/ids/ids.h"
#include "core/map/keyframe.h"
#include "core/map/loop_closure.h"
#include "core/map/map_update.h"
#include "core/process/process.h"

namespace plslam::loop {

struct RelocalisationRequest {
  Keyframe frame;
};
struct SignOfLife {
  SourceId source;
};
/// A LoopClosure is a finished global bundle adjustment.
using Arrival = std::variant<Keyframe, MapUpdate, RelocalisationRequest, SignOfLife, LoopClosure>;

/// Arrivals for the checking worker, in order, counted in the status of the process. Safe from any thread.
class ArrivalQueue {
 public:
  explicit ArrivalQueue(bus::Process& process) : process_(process) {}

  /// A map with this camera has arrived: from the first on, arrivals are taken.
  void Open(const StereoCamera& camera);
  bool is_open() const;
  /// If the worker is far behind, this blocks for a while: the calling thread of the bus then accepts no more, and
  /// publishers keep their messages.
  void Add(Arrival arrival);
  /// Waits for the oldest arrival, at most for `limit`.
  std::optional<Arrival> Take(std::chrono::milliseconds limit);
  /// Camera of the first map. Requires an open queue.
  StereoCamera camera() const;

  /// Ends every wait.
  void Stop();
  bool stopped() const;

 private:
  enum class State {
    kClosed,   ///< until a map arrives: the worker cannot start without it, and it arrives through this queue
    kOpen,     ///< until the process ends
    kStopped,  ///< nothing is taken any more
  };

  bool HasRoom() const;
  /// `more` is 1 for an arrival that is queued, -1 for one that leaves the queue.
  void Count(const Arrival& arrival, int more);

  bus::Process& process_;
  mutable std::mutex mutex_;  // guards all of the following
  std::condition_variable changed_;
  State state_ = State::kClosed;
  std::optional<StereoCamera> camera_;
  std::deque<Arrival> arrivals_;
  int64_t n_keyframes_ = 0;
};

}  // namespace plslam::loop
